// Implicit time steps of a finite element body: implicit Euler, and generalized-alpha (Chung, Hulbert 1993), second
// order with numerical damping chosen by the spectral radius at high frequencies. With F the static forces less the
// external ones, a step balances
//   M [(1 - am) a' + am a] + C [(1 - af) v' + af v] + (1 - af) F(x') + af F(x) = 0
// where am = af = 0 for implicit Euler, and a', v' follow from x' by the scheme.
#pragma once

#include "core/fem_solver.hpp"
#include "core/fem_time_scheme.hpp"

namespace tissued::core {

class FemDynamics {
 public:
  // Keeps a reference. `damping` is added to what the model has of itself. Throws ModelError where a number is out of
  // its range.
  FemDynamics(FemEquilibrium& equilibrium, const TimeScheme& scheme, const RayleighDamping& damping);

  // Accelerations at free nodes that balance the state's forces and velocities under these loads: for a state that was
  // let go, or a load that sets in. Throws ModelError where the mass matrix is not definite.
  void start(FemState& state, const FemLoads& loads);

  // One step of dt s. On failure the state is the one before.
  FemReport step(FemState& state, const FemLoads& loads, double dt, const FemControl& control);

  // kPa mm3.
  double kinetic_energy(const FemState& state) const;

 private:
  struct Coefficients {
    double mass_share, force_share;  // am, af
    double acceleration, velocity;   // by x': 1/s2, 1/s
  };
  Coefficients coefficients(double dt) const;
  void refresh();
  void prepare(double dt);
  Eigen::VectorXd mass_times(const Eigen::VectorXd& field) const;
  Eigen::VectorXd damping_times(const Eigen::VectorXd& field) const;

  FemEquilibrium* equilibrium_;
  TimeScheme scheme_;
  RayleighDamping rates_;
  std::vector<double> mass_, damping_, matrix_;  // of the pattern; matrix: what multiplies x', for dt_
  double dt_ = 0.0;
  std::uint64_t revision_ = 0;  // of the model, when mass and damping were summed
};

}  // namespace tissued::core
