// Quasi-static answers of a finite element body, from any state to any loads.
#pragma once

#include <span>
#include <vector>

#include "core/fem_equilibrium.hpp"
#include "core/simulator.hpp"

namespace tissued::core {

struct FemLoads {
  std::span<const PadInput> pads;             // one entry per pad of the scene
  const Eigen::VectorXd* external = nullptr;  // (3n) mN, dead forces on nodes; null: none
};

// Where the body is. Copy it to branch.
struct FemState {
  Eigen::VectorXd x, velocity, acceleration;  // (3n) mm, mm/s, mm/s2
  Eigen::VectorXd force;                      // (3n) mN: of the terms, less the external forces, at x
  Eigen::VectorXd reaction;                   // (3n) mN: what holds the held nodes: `force`, and inertia and damping
  FemHistory history;                         // of the terms
  FemHold hold;                               // of the last solve
  std::vector<Vec3> pressed;                  // (pads) N, of pads that terms press on
};

// At rest, nothing held but the fixed nodes.
FemState rest_state(const FemModel& model);

// Where pads of kind pose hold their nodes. A node of two pads follows the first; a fixed node stays.
FemHold hold_of(const FemModel& model, std::span<const PadInput> pads);
// (3n) mN: pads of kind force, and loads.external.
Eigen::VectorXd external_forces(const FemModel& model, const FemLoads& loads);

// Moves the state to equilibrium with the loads; time_step s passes for terms with history. On failure the state is the
// last that converged on the way, its history untouched.
FemReport solve_static(FemEquilibrium& equilibrium, FemState& state, const FemLoads& loads, const FemControl& control,
                       double time_step = 0.0);

// N, of each pad on the tissue: what holds its nodes or presses it on, or the force it was given. Zero where absent.
std::vector<Vec3> pad_forces(const FemState& state, std::span<const PadInput> pads);

}  // namespace tissued::core
