// Exact derivatives of an equilibrium: of what is seen (markers, targets, pad forces) by what could be otherwise (any
// parameter of a term, a pad's pose, the stiffness of every element). In equilibrium R(x, p) = 0 at free nodes, so
//   direct:  K_ff dx_f = -dR_f/dp - K_fh dx_h,                one solve a perturbation, for all observables;
//   adjoint: K_ff l = -(do/dx_f + K_fh c), then do/dp = l.dR/dp, one solve an observable, for all perturbations.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/fem_solver.hpp"

namespace tissued::core {

// A direction in which something could change, per unit of it.
struct FemPerturbation {
  Eigen::VectorXd residual;  // (3n) mN: change of the residual at unchanged positions
  Eigen::VectorXd held;      // (3n) mm: move of held nodes; zero elsewhere
};

// What is seen, linear in positions and in the forces that hold the held nodes: position . x + force . reaction.
struct FemObservable {
  Eigen::VectorXd position;  // (3n), per mm
  Eigen::VectorXd force;     // (3n), per mN; zero at free nodes
};

struct FemResponse {
  Eigen::VectorXd x;         // (3n) mm
  Eigen::VectorXd reaction;  // (3n) mN, at held nodes; zero elsewhere
};

// The derivative of one observable by everything at once.
struct FemAdjoint {
  Eigen::VectorXd residual;  // (3n): by the residual of every node
  Eigen::VectorXd held;      // (3n): by the position of every held node; zero elsewhere
};

double derivative(const FemObservable& observable, const FemResponse& response);
double derivative(const FemAdjoint& adjoint, const FemPerturbation& perturbation);

class FemSensitivity {
 public:
  // Factors the tangent at a state that solve_static has found; both outlive this, and the state must not change.
  // time_step: of that solve. What terms remember is taken as it is in state.history: for the derivative at a given
  // past that is the history before the solve. Throws ModelError where the tangent is not definite.
  FemSensitivity(FemEquilibrium& equilibrium, const FemState& state, double time_step = 0.0);

  // By a parameter of that name, in every term that has it. Throws ModelError where none has, or one knows no
  // derivative.
  FemPerturbation by_parameter(const std::string& name);
  // By moving a held pad along an axis, per mm; by turning it about an axis through `center`, per rad.
  FemPerturbation by_pad_shift(int pad, const Vec3& axis) const;
  FemPerturbation by_pad_turn(int pad, const Vec3& axis, const Vec3& center) const;
  // By the logarithm of the solid's stiffness along a field, (elements x points per element).
  FemPerturbation by_log_stiffness(const std::vector<double>& field) const;

  FemObservable of_marker(int marker, const Vec3& axis) const;  // mm
  FemObservable of_target(int target, const Vec3& axis) const;  // mm
  // N. Of a pad that a term presses on: but for what changes the term or moves the pad itself.
  FemObservable of_pad_force(int pad, const Vec3& axis) const;

  FemResponse response(const FemPerturbation& perturbation) const;
  FemAdjoint adjoint(const FemObservable& observable) const;
  // Per element: derivative by the logarithm of its stiffness.
  std::vector<double> by_element_stiffness(const FemAdjoint& adjoint) const;

 private:
  FemObservable of_point(const FemPoint& point, const Vec3& axis) const;
  FemPerturbation nothing() const;
  template <typename Visit>
  void visit_pad_nodes(int pad, const Visit& visit) const;
  TermInput input_of_solid() const;

  FemEquilibrium* equilibrium_;
  const FemState* state_;
  double time_step_;
  std::vector<double> tangent_;            // of the pattern
  std::vector<double> element_residuals_;  // (elements x nodes x 3) mN, of the solid
};

}  // namespace tissued::core
