// What a body with inertia would show from its release on, and how that changes with its numbers.
#pragma once

#include <span>
#include <string>

#include "core/diagnosis/path_solver.hpp"

namespace tissued::core {

// Steps of generalized-alpha between the keys of a path with a motion, with hardly any damping of its own; derivatives
// by bodies that go along with the first, each with one of its numbers a little to the side. As PathSolver::solve.
bool solve_motion(PathSolver& body, const LoadPath& path, std::span<const PathParameter> parameters, PathAnswer& answer,
                  std::string& trouble);

}  // namespace tissued::core
