// Static equilibrium by ADMM: equation (7) without inertia, iterated until it is one.
#pragma once

#include <functional>
#include <vector>

#include "core/simulator.hpp"

namespace tissued::core {

struct StaticOptions {
  Element element = Element::smoothed;
  double tolerance = 1e-6;  // mm; see StaticSolution::residual
  int max_iterations = 20000;
  int anderson_depth = 8;     // history of the acceleration; 0: plain ADMM
  double weight_scale = 4.0;  // doubled when the iteration stalls
  double load_step = 5.0;     // mm; pads are ramped by at most this much at a time
  int threads = 0;
};

struct StaticIteration {
  int iteration;
  double load;      // share of the pads' way that is applied
  double residual;  // mm, as StaticSolution::residual
};

struct StaticSolution {
  NodeField positions;           // (n x 4) mm
  std::vector<Vec3> pad_forces;  // N, of the pad on the tissue
  int iterations = 0;
  int accelerated = 0;          // Anderson steps kept by the safeguard
  int rejected = 0;             // Anderson steps it refused
  double weight_scale = 0.0;    // the one it ended with
  double residual = 0.0;        // mm: largest entry of L^-1 times the unbalanced force at free nodes
  double force_residual = 0.0;  // N: largest unbalanced force at a free node
  int inverted = 0;
  bool converged = false;
  std::string trouble;  // empty, or in words what stopped it and at which load
};

// pads: one entry per pad of the scene. `watch`, where set, is called once an iteration (for curves).
StaticSolution solve_static(const Scene& scene, std::span<const PadInput> pads, const StaticOptions& options,
                            const std::function<void(const StaticIteration&)>& watch = {});

}  // namespace tissued::core
