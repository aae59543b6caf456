#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/trial_player.hpp"

namespace tissued::daemon {

/// How far one target's predictions are from its recorded places, in one trial. NaN where nothing can be compared.
struct TargetError {
  std::string name;
  double hold_mm;  ///< |mean prediction - mean recorded place|, each over the hold: the sensor's noise averages out
  double rms_mm;   ///< over all frames answered, the sensor's noise included
  std::size_t frames = 0;  ///< compared one by one
};

/// Where a target was said to be in frame `index` of the recording, mm, tracker; nothing where nothing was said.
using PredictedPlace = std::function<std::optional<core::Vec3>(std::size_t index)>;

/// mm; |mean of `predicted` - mean recorded place of target `target`|, each over the recording's hold. NaN where either
/// has no frame there.
double hold_error_mm(const Recording& recording, std::size_t target, const PredictedPlace& predicted);

/// One entry per target of the bundle. `daemon_names`: the daemon's table of targets, in which predictions name theirs.
std::vector<TargetError> target_errors(const config::Bundle& bundle, const Recording& recording,
                                       const PlayedTrial& played, const std::vector<std::string>& daemon_names);

/// Means over the targets that have a value; NaN where none has.
double mean_hold_mm(const std::vector<TargetError>& errors);
double mean_rms_mm(const std::vector<TargetError>& errors);

/// What the daemon said as a recording: targets per frame, forces of the pads as devices, frames without an answer as
/// gaps. Frame numbers are those of the original.
protocol::Trial predictions_as_trial(const config::Bundle& bundle, const Recording& recording,
                                     const PlayedTrial& played, const std::vector<std::string>& target_names,
                                     const std::vector<std::string>& pad_names);

}  // namespace tissued::daemon
