#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "config/daemon_config.hpp"
#include "daemon/frame_processor.hpp"
#include "daemon/recording.hpp"

namespace tissued::daemon {

/// One target in one frame of a run.
struct TargetSample {
  core::Vec3 position;                 ///< mm, tracker: the answer
  std::array<double, 6> covariance{};  ///< mm2: xx, xy, xz, yy, yz, zz; zero where nothing is claimed
  std::optional<core::Vec3> measured;  ///< mm, tracker: as recorded, the sensor's noise included

  /// mm; answer minus measurement, which must be there.
  core::Vec3 error() const { return position - *measured; }
};

struct RunFrame {
  std::size_t index = 0;  ///< of the frame in the recording
  double time = 0.0;      ///< s, tracker's clock, since the run's first frame
  bool contact = false;   ///< a pad touches the tissue
  bool diverged = false;  ///< the step was thrown away and the last good answer held
  int iterations = 0;     ///< ADMM, in this frame
  int markers_used = 0;
  double innovation_rms = 0.0;  ///< mm per axis, of the markers used, before the correction
  std::uint64_t step_time_ns = 0;
  AlarmAnswer alarm;
  std::vector<TargetSample> targets;  ///< (targets of the bundle)
};

/// What tissued answers to every frame of a recording.
using TrialRun = std::vector<RunFrame>;

/// The frames of a recording as they were recorded.
std::vector<std::size_t> recorded_order(const Recording& recording);

/// Frames in which the pads jump, as in the first paper: the opening rest, then at once `count` frames of the hold,
/// over and over. Empty where the recording has no hold.
std::vector<std::size_t> jump_order(const Recording& recording, std::size_t count);

/// A simulator behind the same stages as in tissued: names, rest calibration, registration, clock, step. No sockets, no
/// threads. From run to run it keeps what it has learnt and calibrated, as tissued does from trial to trial.
class TrialRunner {
 public:
  /// scene: config.bundle's with its mesh. pad_forces: recorded ones are fed, too. Throws core::ModelError where the
  /// simulator cannot be built.
  TrialRunner(const config::DaemonConfig& config, const core::Scene& scene, bool pad_forces = false);

  /// Feeds frames of the recording, in `order`, at the recorded rate and with none lost; a pause of a second, in which
  /// the pads are lifted, parts them from the run before. Throws std::runtime_error where a frame holds more than a
  /// tracker frame can.
  TrialRun run(const Recording& recording, std::span<const std::size_t> order);

 private:
  Counters counters_;
  std::unique_ptr<core::Simulator> simulator_;
  std::unique_ptr<FrameProcessor> processor_;
  std::unique_ptr<protocol::TrackerFrame> frame_;
  Answer answer_;
  RecordingItems items_;
  std::uint32_t frames_ = 0;
  std::uint64_t begin_ns_;  // of the next run
};

/// One run by a simulator fresh from rest.
TrialRun run_trial(const config::DaemonConfig& config, const core::Scene& scene, const Recording& recording,
                   std::span<const std::size_t> order, bool pad_forces = false);

}  // namespace tissued::daemon
