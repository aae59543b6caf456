// Derivatives along a path against central differences of whole solves.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/diagnosis/path_solver.hpp"

namespace tissued::core::testing {

// Sets the body's numbers to these, and leaves them so. share: of each number, to either side. tolerance: of the
// difference's norm, what the derivative may be off by; solves stop at 1e-4 mm.
void check_derivatives(PathSolver& solver, const LoadPath& path,
                       const std::vector<std::pair<std::string, double>>& numbers, double share, double tolerance);

}  // namespace tissued::core::testing
