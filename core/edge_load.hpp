// What dead loads along edges do to a finite element body.
#pragma once

#include <span>
#include <vector>

#include "core/fem_model.hpp"

namespace tissued::core {

// (3n) mN, on the nodes of the body, spread evenly along each edge. Throws ModelError where no edges of the mesh lie
// along one.
Eigen::VectorXd forces_of(const FemModel& model, std::span<const EdgeLoad> loads);

// The masses of the loads, kg, as values of the model's pattern. Throws likewise.
std::vector<double> masses_of(const FemModel& model, std::span<const EdgeLoad> loads);

}  // namespace tissued::core
