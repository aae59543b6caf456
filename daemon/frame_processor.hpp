#pragma once

#include <vector>

#include "config/daemon_config.hpp"
#include "core/rest_calibration.hpp"
#include "core/simulator.hpp"
#include "daemon/answer.hpp"
#include "daemon/counters.hpp"
#include "daemon/frame_clock.hpp"
#include "daemon/name_table.hpp"
#include "daemon/pad_tracker.hpp"
#include "daemon/probe_tracker.hpp"
#include "daemon/rest_gate.hpp"
#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

/// Under which a step is taken: see core::Observation.
struct StepTerms {
  int overload = 0;        ///< OverloadRule's level
  int max_iterations = 0;  ///< 0: as configured
  core::StepBrake brake;
};

/// From one tracker frame to one answer: names to indices, tracker to tissue coordinates, rest calibration, measured
/// dt, the simulator's step, and back. Neither sockets nor threads; after construction nothing allocates (but the
/// simulator, when the tracker has changed its rate) and nothing throws.
///
/// Markers are fed with the offsets that the rest calibration has found, shrunk by their prior. Before any frame at
/// rest was seen all offsets are zero: the bundle says where markers are, to its placement_sd. A marker that first
/// appears once others have been calibrated is withheld until the tissue is at rest again, for its unknown offset would
/// read as a deformation. In a frame without markers those of an earlier frame that came late are used, with their age.
class FrameProcessor {
 public:
  /// The simulator, made from config.bundle's scene and mesh, and the counters must outlive the processor.
  /// Throws core::ModelError where the scene does not fit into a tracker frame or an Answer, or names are ambiguous.
  FrameProcessor(core::Simulator& simulator, const config::DaemonConfig& config, Counters& counters);

  /// Steps the simulator by one frame and writes what it knows then into `answer`, every field of it. Where the result
  /// is not finite, or further from the body than the body is long, or the step was braked, the answer is `previous`
  /// once more, with kDiverged; the simulator goes on from the last good state, or, lost in space, from rest.
  void process(const protocol::TrackerFrame& frame, const Answer& previous, Answer& answer,
               const StepTerms& terms = {}) noexcept;

  /// s, between the frame that was processed last and the one before it, as far as it could be told.
  double frame_interval() const { return observation_.dt; }

  /// The answer before any frame: the targets at rest.
  void rest_answer(Answer& answer) const noexcept;

  /// Where the nodes are now, of the frame that `answer` is about. False, with `mesh` as it was, where the simulation
  /// has begun anew and `answer` is still of before.
  bool snapshot(const Answer& answer, MeshSnapshot& mesh) const noexcept;

 private:
  // What the tracker said about markers and targets in the frame at hand.
  struct Seen {
    std::vector<core::Vec3> markers;  // mm, tracker
    std::vector<std::uint8_t> marker_seen;
    std::array<std::optional<std::array<double, 3>>, kMaxTargets> truth;
    std::uint16_t marker_count = 0;
  };

  void read_names(const protocol::TrackerFrame& frame);
  void read_late_markers(const protocol::TrackerFrame& frame);
  template <typename Markers>
  std::uint64_t read_markers(const Markers& markers);
  void calibrate(double elapsed);
  void observe(const FrameInterval& interval, bool whole);
  void follow_rate();
  std::uint16_t reasons_of(const core::StepReport& report, const protocol::TrackerFrame& frame,
                           std::uint64_t step_time_ns) const;
  bool write_estimates(Answer& answer) const noexcept;
  bool within_reach(const core::Vec3& position) const noexcept;
  bool write_probes(Answer& answer) const noexcept;
  void write_alarm(const protocol::TrackerFrame& frame, const AlarmAnswer& previous,
                   const core::MismatchReport& mismatch, AlarmAnswer& alarm) const noexcept;

  bool registered() const { return !fit_ || calibration_.registration().determined; }
  const core::RigidTransform& tissue_from_tracker() const { return calibration_.registration().tissue_from_tracker; }

  core::Simulator& simulator_;
  Counters& counters_;
  NameTable names_;
  FrameClock clock_;
  PadTracker pads_;
  ProbeTracker probes_;
  std::vector<std::optional<core::ImagePlane>> images_;  // (probes)
  RestGate rest_gate_;
  core::RestCalibration calibration_;
  bool fit_;                                // the registration is found from markers at rest
  int rest_frames_;                         // averaged at most
  bool closed_loop_;                        // the simulator corrects itself by markers
  double marker_delay_;                     // s by which markers are older than their frame says
  core::RigidTransform marker_correction_;  // tracker to tracker
  bool late_ = false;                       // the markers of this frame are those of an earlier one
  Seen seen_;
  core::Observation observation_;
  core::Vec3 centre_;  // mm, tissue: of the body at rest
  double reach_;       // mm from there
  int markers_fed_ = 0;
  int pads_held_ = 0;              // and probes
  bool pressed_by_probe_ = false;  // in the last step
  bool mesh_is_of_answer_ = true;
};

}  // namespace tissued::daemon
