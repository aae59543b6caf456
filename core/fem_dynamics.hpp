// Implicit time steps of a finite element body: implicit Euler, and generalized-alpha (Chung, Hulbert 1993), second
// order with numerical damping chosen by the spectral radius at high frequencies. With F the static forces less the
// external ones, a step balances
//   M [(1 - am) a' + am a] + C [(1 - af) v' + af v] + (1 - af) F(x') + af F(x) = 0
// where am = af = 0 for implicit Euler, and a', v' follow from x' by the scheme.
#pragma once

#include <optional>

#include "core/fem_solver.hpp"
#include "core/fem_time_scheme.hpp"

namespace tissued::core {

class FemDynamics {
 public:
  // Keeps a reference. `damping` is added to what the model has of itself; carried: likewise mass, kg, as values of the
  // model's pattern, or empty. Throws ModelError where a number is out of its range.
  FemDynamics(FemEquilibrium& equilibrium, const TimeScheme& scheme, const RayleighDamping& damping,
              std::vector<double> carried = {});

  // Other steps from here on; mass and damping stay.
  void use(const TimeScheme& scheme);

  // Accelerations at free nodes that balance the state's forces and velocities under these loads: for a state that was
  // let go, or a load that sets in. Throws ModelError where the mass matrix is not definite.
  void start(FemState& state, const FemLoads& loads);

  // One step of dt s. On failure the state is the one before.
  FemReport step(FemState& state, const FemLoads& loads, double dt, const FemControl& control);

  // Derivatives of a motion: bodies whose numbers differ a little from this one's go along with it. Where a step ended,
  // and what it left out of balance there, (3n) mN.
  struct Guide {
    Eigen::VectorXd x, unbalanced;
  };
  // Factors what a step of dt from `before` that ended at `after` balances with. None where that is not definite.
  std::optional<Guide> guide(const FemState& before, const FemState& after, const FemLoads& loads, double dt);
  // The step of such a body, from a state near `before`: one of Newton's corrections with that factor, and as much left
  // out of balance. Of a FemDynamics of its own on the same equilibrium, which has its numbers set and its matrices of
  // them (see keep_matrices).
  void follow(const Guide& guide, FemState& state, const FemLoads& loads, double dt);
  // Numbers of the model were set and set back again since the matrices were summed: they are still right.
  void keep_matrices() { revision_ = equilibrium_->model().revision(); }

  // kPa mm3.
  double kinetic_energy(const FemState& state) const;

 private:
  struct Coefficients {
    double mass_share, force_share;  // am, af
    double acceleration, velocity;   // by x': 1/s2, 1/s
  };
  // What does not depend on where a step ends: a' = acceleration (x' - x) + a0, v' = velocity (x' - x) + v0.
  struct Step {
    Coefficients c;
    Eigen::VectorXd a0, v0, external;
    FemBalance balance;
  };
  Coefficients coefficients(double dt) const;
  void refresh();
  void prepare(double dt);
  void sum_matrix(double dt);
  Step step_from(const FemState& state, const FemLoads& loads, double dt) const;
  void arrive(const Step& step, const Eigen::VectorXd& x, Eigen::VectorXd force, double dt, FemState& state) const;
  Eigen::VectorXd mass_times(const Eigen::VectorXd& field) const;
  Eigen::VectorXd damping_times(const Eigen::VectorXd& field) const;

  FemEquilibrium* equilibrium_;
  TimeScheme scheme_;
  RayleighDamping rates_;
  std::vector<double> carried_;
  std::vector<double> mass_, damping_, matrix_;  // of the pattern; matrix: what multiplies x', for dt_
  double dt_ = 0.0;
  bool is_damped_ = false;
  std::uint64_t revision_ = 0;  // of the model, when mass and damping were summed
};

}  // namespace tissued::core
