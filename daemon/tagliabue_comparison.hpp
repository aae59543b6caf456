#pragma once

#include <string>

#include "daemon/evaluation.hpp"

namespace tissued::daemon {

/// Whether the bundle repeats the calibration block or the breast of the second paper.
bool repeats_tagliabue(const BundleEvaluation& bundle);

/// HTML: Table 2 (calibrated clusters), Table 3 (error by lesion and push) and figures 6 and 7 of the second paper from
/// our runs, what each model costs, and beside them what the paper prints.
std::string tagliabue_comparison(const BundleEvaluation& bundle);

}  // namespace tissued::daemon
