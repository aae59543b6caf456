#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "config/daemon_config.hpp"
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
  std::vector<TargetSample> targets;  ///< (targets of the bundle)
};

/// What tissued answers to every frame of a recording.
using TrialRun = std::vector<RunFrame>;

/// The frames of a recording as they were recorded.
std::vector<std::size_t> recorded_order(const Recording& recording);

/// Frames in which the pads jump, as in the first paper: the opening rest, then at once `count` frames of the hold,
/// over and over. Empty where the recording has no hold.
std::vector<std::size_t> jump_order(const Recording& recording, std::size_t count);

/// Feeds frames of the recording, in `order`, at the recorded rate and with none lost, to a simulator fresh from rest,
/// through the same stages as tissued does: names, rest calibration, registration, clock, step. No sockets, no threads.
/// scene: config.bundle's with its mesh. Throws core::ModelError where the simulator cannot be built, and
/// std::runtime_error where a frame holds more than a tracker frame can.
TrialRun run_trial(const config::DaemonConfig& config, const core::Scene& scene, const Recording& recording,
                   std::span<const std::size_t> order);

}  // namespace tissued::daemon
