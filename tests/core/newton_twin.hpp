// Static equilibrium by Newton's method on the plain sum of strain energies: shares nothing with ADMM but the energy.
#pragma once

#include <functional>
#include <vector>

#include "core/scene.hpp"
#include "core/simulator.hpp"

namespace tissued::core::testing {

struct TwinAnswer {
  NodeField positions;          // (n x 4) mm
  std::vector<Vec3> reactions;  // (n) N, what the supports and pads do to each node; zero where nothing holds
  double unbalanced = 0.0;      // N, largest at a free node
};

// Base still; pads of kind pose carry their nodes along; `external`: (n x 4) mN; `loads`: steps the way is cut into.
TwinAnswer solve_by_newton(const Scene& scene, const std::vector<PadInput>& pads, const NodeField& external, int loads);

// (n x 4) mN: gravity on lumped masses, and each pad's force by the area of its facets.
NodeField external_forces(const Scene& scene, const std::vector<PadInput>& pads);

}  // namespace tissued::core::testing
