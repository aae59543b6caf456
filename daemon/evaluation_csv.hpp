#pragma once

#include <iosfwd>

#include "daemon/evaluation.hpp"

namespace tissued::daemon {

/// One row per bundle, trial, model, marker set and target; one row with an empty target where a bundle has none. Cells
/// are empty where there is nothing to say. Columns: daemon/README.md.
void write_runs_csv(const Evaluation& evaluation, std::ostream& out);

/// One row per target and frame of every run, in the same order.
void write_frames_csv(const Evaluation& evaluation, std::ostream& out);

}  // namespace tissued::daemon
