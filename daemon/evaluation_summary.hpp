#pragma once

#include <string>
#include <vector>

#include "daemon/evaluation.hpp"

namespace tissued::daemon {

/// What the runs of one setup come to, over all trials of its bundle. NaN where there is nothing to say.
struct SetupSummary {
  double first_hold_mm;  ///< of the bundle's first target, mean over trials
  double hold_mm;        ///< mean over trials and targets; so are all that follow, unless said otherwise
  double rms_mm;         ///< root of the mean square over all frames compared
  double p95_mm;         ///< over all frames compared
  double max_mm;         ///< over all frames compared
  double inside_95;      ///< share of all frames compared
  double nees;
  double inside_95_sensor;
  double nees_sensor;
  double innovation_rms_mm;
  double step_p50_ms;  ///< over all frames stepped
  double step_p99_ms;
  std::size_t frames;    ///< stepped
  std::size_t diverged;  ///< of them
};

SetupSummary summarize(const BundleEvaluation& bundle, std::size_t setup);

/// A table for the terminal: one row per bundle, model and marker set.
std::string evaluation_summary(const Evaluation& evaluation);

}  // namespace tissued::daemon
