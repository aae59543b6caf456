#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "daemon/trial_run.hpp"

namespace tissued::daemon {

/// How far one target's answers are from its measurements in one run, over the frames that are compared: those in which
/// the target was measured and a pad touched the tissue (in a bundle without pads: all in which it was measured).
/// NaN where there is nothing to say.
struct TargetScore {
  std::string name;
  std::size_t frames = 0;  ///< compared
  double hold_mm;          ///< |mean answer - mean measurement| over the hold: the sensor's noise averages out
  double mean_mm;          ///< of |answer - measurement|, the sensor's noise included, as below
  double rms_mm;
  double p95_mm;  ///< what 95 % of the frames do not exceed
  double max_mm;
  double inside_95;         ///< share of the measurements inside the answer's 95 % ellipsoid
  double nees;              ///< mean normalized square; 3 where the covariance is right
  double inside_95_sensor;  ///< the same two with the sensor's stated noise added to the ellipsoid, as it is in the
  double nees_sensor;       ///< measurement
};

struct RunScore {
  std::vector<TargetScore> targets;  ///< (targets of the bundle)
  std::size_t frames = 0;            ///< stepped
  std::size_t diverged = 0;          ///< of them thrown away
  double innovation_rms_mm;          ///< per axis, over all markers used in all frames; NaN in open loop
  double step_p50_ms;
  double step_p99_ms;
};

/// Scores a run of the recording's frames as they were recorded. bundle: the recording's.
RunScore score_run(const config::Bundle& bundle, const Recording& recording, const TrialRun& run);

/// Whether a frame counts for a target: see TargetScore.
bool is_compared(const config::Bundle& bundle, const RunFrame& frame, std::size_t target);

/// Normalized squares of errors, by the covariance as it is claimed and with the sensor's stated noise added.
struct NormalizedSquares {
  std::vector<double> claimed;
  std::vector<double> with_sensor;
};

/// Of the compared frames of all targets. Empty where nothing is claimed.
NormalizedSquares normalized_squares(const config::Bundle& bundle, const TrialRun& run);

/// The smallest value that `share` (0 to 1) of all do not exceed. NaN where there is none.
double percentile(std::vector<double> values, double share);

/// Mean of the finite ones among `values`; NaN where there is none.
double finite_mean(std::span<const double> values);

}  // namespace tissued::daemon
