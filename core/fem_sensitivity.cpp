#include "core/fem_sensitivity.hpp"

#include <Eigen/Geometry>

namespace tissued::core {

namespace {

// Keeps entries of free nodes (held = false) or of held ones (held = true).
Eigen::VectorXd only(const std::vector<std::uint8_t>& is_held, bool held, const Eigen::VectorXd& field) {
  Eigen::VectorXd out = field;
  for (std::size_t i = 0; i < is_held.size(); ++i)
    if ((is_held[i] != 0) != held) out.segment<3>(3 * static_cast<Eigen::Index>(i)).setZero();
  return out;
}

// Adds the entities' residuals to their nodes.
void scatter(const FemTerm& term, const std::vector<double>& entities, Eigen::VectorXd& out) {
  const double* from = entities.data();
  for (int e = 0; e < term.entity_count(); ++e)
    for (int node : term.nodes_of_entity(e))
      for (int axis = 0; axis < 3; ++axis) out[3 * node + axis] += *from++;
}

}  // namespace

double derivative(const FemObservable& observable, const FemResponse& response) {
  return observable.position.dot(response.x) + observable.force.dot(response.reaction);
}

double derivative(const FemAdjoint& adjoint, const FemPerturbation& perturbation) {
  return adjoint.residual.dot(perturbation.residual) + adjoint.held.dot(perturbation.held);
}

FemSensitivity::FemSensitivity(FemEquilibrium& equilibrium, const FemState& state, double time_step)
    : equilibrium_(&equilibrium), state_(&state), time_step_(time_step) {
  Eigen::VectorXd residual;
  equilibrium.set_pads(state.hold.pads);
  equilibrium.terms(state.x, time_step, state.history, residual, &tangent_);
  equilibrium.forget_factor();
  if (!equilibrium.factor().factorize(tangent_, state.hold.held))
    throw ModelError("the tangent is not definite: the equilibrium is not stable, or a part of the body is not held");
  const FemSolid& solid = equilibrium.model().solid();
  element_residuals_.resize(static_cast<std::size_t>(3 * solid.nodes_per_entity() * solid.entity_count()));
  solid.evaluate(0, solid.entity_count(), input_of_solid(), {nullptr, element_residuals_.data(), nullptr});
}

TermInput FemSensitivity::input_of_solid() const {
  return {state_->x.data(), time_step_, state_->history[0].data(), state_->hold.pads};
}

FemPerturbation FemSensitivity::nothing() const {
  return {Eigen::VectorXd::Zero(state_->x.size()), Eigen::VectorXd::Zero(state_->x.size())};
}

FemPerturbation FemSensitivity::by_parameter(const std::string& name) {
  FemPerturbation perturbation = nothing();
  bool found = false;
  const auto& terms = equilibrium_->model().terms();
  const std::string& own_name = equilibrium_->model().own_name(name);
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (std::size_t k = 0; k < terms[t]->parameters().size(); ++k) {
      if (terms[t]->parameters()[k].name != own_name) continue;
      if (!terms[t]->has_derivative(static_cast<int>(k)))
        throw ModelError("the derivative by " + name + " has no closed form; take differences");
      Eigen::VectorXd residual;
      equilibrium_->assembler().differentiate(static_cast<int>(t), static_cast<int>(k), state_->x, time_step_,
                                              state_->history, residual);
      perturbation.residual += residual;
      found = true;
    }
  }
  if (!found) throw ModelError("no term of the body has a parameter " + name);
  return perturbation;
}

// The nodes that this pad holds: not those that are fixed, nor those that an earlier pad holds.
template <typename Visit>
void FemSensitivity::visit_pad_nodes(int pad, const Visit& visit) const {
  const FemModel& model = equilibrium_->model();
  for (int node : model.pad_nodes()[pad])
    if (state_->hold.pad[node] == pad) visit(node);
}

FemPerturbation FemSensitivity::by_pad_shift(int pad, const Vec3& axis) const {
  FemPerturbation perturbation = nothing();
  visit_pad_nodes(pad, [&](int node) { perturbation.held.segment<3>(3 * node) = axis; });
  return perturbation;
}

FemPerturbation FemSensitivity::by_pad_turn(int pad, const Vec3& axis, const Vec3& center) const {
  FemPerturbation perturbation = nothing();
  visit_pad_nodes(pad, [&](int node) {
    perturbation.held.segment<3>(3 * node) = axis.cross(state_->x.segment<3>(3 * node) - center);
  });
  return perturbation;
}

FemPerturbation FemSensitivity::by_log_stiffness(const std::vector<double>& field) const {
  FemPerturbation perturbation = nothing();
  const FemSolid& solid = equilibrium_->model().solid();
  std::vector<double> residuals(element_residuals_.size());
  solid.differentiate_stiffness(field, 0, solid.entity_count(), input_of_solid(), residuals.data());
  scatter(solid, residuals, perturbation.residual);
  return perturbation;
}

FemObservable FemSensitivity::of_point(const FemPoint& point, const Vec3& axis) const {
  FemObservable observable{Eigen::VectorXd::Zero(state_->x.size()), Eigen::VectorXd::Zero(state_->x.size())};
  for (int a = 0; a < point.count; ++a) observable.position.segment<3>(3 * point.nodes[a]) += point.weights[a] * axis;
  return observable;
}

FemObservable FemSensitivity::of_marker(int marker, const Vec3& axis) const {
  return of_point(equilibrium_->model().marker_points()[marker], axis);
}

FemObservable FemSensitivity::of_target(int target, const Vec3& axis) const {
  return of_point(equilibrium_->model().target_points()[target], axis);
}

FemObservable FemSensitivity::of_pad_force(int pad, const Vec3& axis) const {
  FemObservable observable{equilibrium_->pressed_slope(pad, axis, state_->x, time_step_, state_->history),
                           Eigen::VectorXd::Zero(state_->x.size())};
  visit_pad_nodes(pad, [&](int node) { observable.force.segment<3>(3 * node) = axis / kMillinewtonPerNewton; });
  return observable;
}

FemResponse FemSensitivity::response(const FemPerturbation& perturbation) const {
  const FemPattern& pattern = equilibrium_->model().pattern();
  FemResponse response;
  Eigen::VectorXd product;
  pattern.multiply(tangent_, perturbation.held, product);
  response.x = perturbation.held + equilibrium_->factor().solve(-perturbation.residual - product);
  pattern.multiply(tangent_, response.x, product);
  response.reaction = only(state_->hold.held, true, product + perturbation.residual);
  return response;
}

FemAdjoint FemSensitivity::adjoint(const FemObservable& observable) const {
  const FemPattern& pattern = equilibrium_->model().pattern();
  FemAdjoint adjoint;
  Eigen::VectorXd product;
  pattern.multiply(tangent_, observable.force, product);
  adjoint.residual = observable.force + equilibrium_->factor().solve(-observable.position - product);
  pattern.multiply(tangent_, adjoint.residual, product);
  adjoint.held = only(state_->hold.held, true, observable.position + product);
  return adjoint;
}

std::vector<double> FemSensitivity::by_element_stiffness(const FemAdjoint& adjoint) const {
  const FemSolid& solid = equilibrium_->model().solid();
  std::vector<double> map(static_cast<std::size_t>(solid.entity_count()), 0.0);
  const double* residual = element_residuals_.data();
  for (int e = 0; e < solid.entity_count(); ++e)
    for (int node : solid.nodes_of_entity(e))
      for (int axis = 0; axis < 3; ++axis) map[e] += *residual++ * adjoint.residual[3 * node + axis];
  return map;
}

}  // namespace tissued::core
