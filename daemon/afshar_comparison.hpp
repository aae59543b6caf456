#pragma once

#include <string>

#include "daemon/evaluation.hpp"

namespace tissued::daemon {

/// Whether the bundle repeats the experiments of the first paper.
bool repeats_afshar(const BundleEvaluation& bundle);

/// HTML: what the first paper prints beside what was run, its Table I, and its figures 5 to 7 from our runs.
std::string afshar_comparison(const BundleEvaluation& bundle);

}  // namespace tissued::daemon
