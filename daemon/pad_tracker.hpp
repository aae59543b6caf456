#pragma once

#include <span>
#include <vector>

#include "core/rest_calibration.hpp"
#include "core/scene.hpp"
#include "core/simulator.hpp"

namespace tissued::daemon {

/// From what frames say about pads to what pads do in a step.
///
/// A pad whose pose is seen is prescribed; one that only carries a force is a force. A pad that is missing goes on as
/// it was for kHold, because a lost datagram must not lift it off the skin, and is absent afterwards: where it was last
/// seen pushing, that is a guess, and it counts as missing until it is seen again. Frames with datagrams missing never
/// lift a pad.
class PadTracker {
 public:
  static constexpr double kHold = 0.1;  // s

  /// learn_offsets: pads move from where they are seen at rest, not from where the scene says. For a fitted
  /// registration, whose own error would otherwise push pads that merely rest.
  PadTracker(const std::vector<core::Pad>& pads, double rest_tolerance, double placement_sd, bool learn_offsets);

  /// A new frame begins; nothing is seen in it yet.
  void begin_frame();
  /// position: mm, tracker frame. rotation: tracker frame, of the pad's own axes.
  void see_pose(int pad, const core::Vec3& position, const core::Mat3& rotation);
  /// force: N, tracker frame, of the pad on the tissue.
  void see_force(int pad, const core::Vec3& force);

  /// The tracker has begun anew: where pads were last seen says nothing any more.
  void restart();

  /// Whether every pad is at its rest pose, or pushes with no force to speak of: in this frame, or when it was last
  /// seen. Before there is a registration nothing speaks against it.
  bool at_rest(const core::RigidTransform& tissue_from_tracker, bool registered) const;
  /// Averages this frame's poses into the rest poses: orientation, and place where offsets are learnt. A pad that has
  /// been averaged over max_samples frames stays as it is.
  void learn_rest(int max_samples);

  /// Fills `inputs` (pads) for this frame, and returns how many pads are missing. elapsed: s since the frame before.
  /// whole: no datagram of it was lost.
  int finish_frame(double elapsed, bool whole, const core::RigidTransform& tissue_from_tracker, bool registered,
                   std::span<core::PadInput> inputs);

 private:
  struct State {
    core::Vec3 rest_center;  // mm, tissue, as the scene says
    bool pose_seen = false;  // in this frame
    bool force_seen = false;
    core::Vec3 position = core::Vec3::Zero();  // mm, tracker; the last one seen
    core::Mat3 rotation = core::Mat3::Identity();
    core::Vec3 force = core::Vec3::Zero();  // N, tracker; the last one seen
    core::PadInput::Kind kind = core::PadInput::Kind::absent;
    double unseen = 0.0;   // s since it was last seen as `kind`
    bool pushing = false;  // when it was last seen

    int rest_samples = 0;
    core::Vec3 position_sum = core::Vec3::Zero();               // mm, tracker
    Eigen::Vector4d orientation_sum = Eigen::Vector4d::Zero();  // of unit quaternions, all in one half space
  };

  bool at_rest(const State& pad, const core::RigidTransform& tissue_from_tracker, bool registered) const;
  void advance(State& pad, double elapsed, bool whole) const;
  core::PadInput input_of(const State& pad, const core::RigidTransform& tissue_from_tracker) const;

  std::vector<State> pads_;
  double rest_tolerance_;  // mm
  double coarse_tolerance_;
  bool learn_offsets_;
};

}  // namespace tissued::daemon
