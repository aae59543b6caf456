#include "core/fem_dynamics.hpp"

#include <cmath>
#include <utility>

namespace tissued::core {

FemDynamics::FemDynamics(FemEquilibrium& equilibrium, const TimeScheme& scheme, const RayleighDamping& damping,
                         std::vector<double> carried)
    : equilibrium_(&equilibrium), rates_(damping), carried_(std::move(carried)) {
  use(scheme);
  if (!(damping.mass >= 0.0 && damping.stiffness >= 0.0)) throw ModelError("Rayleigh damping must not be negative");
  refresh();
}

void FemDynamics::use(const TimeScheme& scheme) {
  if (!(scheme.spectral_radius >= 0.0 && scheme.spectral_radius <= 1.0))
    throw ModelError("the spectral radius of generalized-alpha must be within 0 and 1");
  scheme_ = scheme;
  dt_ = 0.0;
}

// Mass and damping of the model's present numbers.
void FemDynamics::refresh() {
  const FemModel& model = equilibrium_->model();
  const Eigen::VectorXd rest = model.rest();
  Eigen::VectorXd residual;
  FemHistory none(model.masses().size());
  FemAssembler(model.pattern(), model.masses(), equilibrium_->assembler().threads())
      .evaluate(rest, 0.0, none, residual, &mass_);
  equilibrium_->set_pads({});
  equilibrium_->terms(rest, 0.0, rest_state(model).history, residual, &damping_);
  const RayleighDamping own = model.damping();
  for (std::size_t k = 0; k < carried_.size(); ++k) mass_[k] += carried_[k];
  for (std::size_t k = 0; k < damping_.size(); ++k)
    damping_[k] = (rates_.mass + own.mass) * mass_[k] + (rates_.stiffness + own.stiffness) * damping_[k];
  is_damped_ = rates_.mass + own.mass > 0.0 || rates_.stiffness + own.stiffness > 0.0;
  matrix_.resize(mass_.size());
  revision_ = model.revision();
  dt_ = 0.0;
}

FemDynamics::Coefficients FemDynamics::coefficients(double dt) const {
  if (scheme_.kind == TimeScheme::Kind::implicit_euler) return {0.0, 0.0, 1.0 / (dt * dt), 1.0 / dt};
  const double radius = scheme_.spectral_radius;
  const double am = (2.0 * radius - 1.0) / (radius + 1.0), af = radius / (radius + 1.0);
  const double gamma = 0.5 - am + af, beta = 0.25 * (1.0 - am + af) * (1.0 - am + af);
  return {am, af, 1.0 / (beta * dt * dt), gamma / (beta * dt)};
}

Eigen::VectorXd FemDynamics::mass_times(const Eigen::VectorXd& field) const {
  Eigen::VectorXd product;
  equilibrium_->model().pattern().multiply(mass_, field, product);
  return product;
}

Eigen::VectorXd FemDynamics::damping_times(const Eigen::VectorXd& field) const {
  Eigen::VectorXd product;
  equilibrium_->model().pattern().multiply(damping_, field, product);
  return product;
}

void FemDynamics::prepare(double dt) {
  if (revision_ != equilibrium_->model().revision()) refresh();
  if (dt != dt_) equilibrium_->forget_factor();
  sum_matrix(dt);
}

void FemDynamics::sum_matrix(double dt) {
  if (dt == dt_) return;
  dt_ = dt;
  const Coefficients c = coefficients(dt);
  for (std::size_t k = 0; k < matrix_.size(); ++k)
    matrix_[k] = (1.0 - c.mass_share) * c.acceleration * mass_[k] + (1.0 - c.force_share) * c.velocity * damping_[k];
}

void FemDynamics::start(FemState& state, const FemLoads& loads) {
  const FemModel& model = equilibrium_->model();
  if (revision_ != model.revision()) refresh();
  state.hold = hold_of(model, loads.pads);
  equilibrium_->set_pads(state.hold.pads);
  equilibrium_->terms(state.x, 0.0, state.history, state.force);
  state.force -= external_forces(model, loads);
  equilibrium_->forget_factor();
  if (!equilibrium_->factor().factorize(mass_, state.hold.held))
    throw ModelError("the mass matrix is not definite: is the density above 0?");
  const Eigen::VectorXd damping = damping_times(state.velocity);
  state.acceleration = equilibrium_->factor().solve(-state.force - damping);
  state.reaction = mass_times(state.acceleration) + damping + state.force;
  equilibrium_->forget_factor();
}

FemDynamics::Step FemDynamics::step_from(const FemState& state, const FemLoads& loads, double dt) const {
  const FemModel& model = equilibrium_->model();
  Step step;
  const Coefficients c = step.c = coefficients(dt);
  step.a0 = -state.velocity / dt;
  step.v0 = Eigen::VectorXd::Zero(state.x.size());
  if (scheme_.kind == TimeScheme::Kind::generalized_alpha) {
    const double gamma = c.velocity / (c.acceleration * dt), inverse_beta = c.acceleration * dt * dt;
    step.a0 = -inverse_beta / dt * state.velocity - (0.5 * inverse_beta - 1.0) * state.acceleration;
    step.v0 = state.velocity + dt * ((1.0 - gamma) * state.acceleration + gamma * step.a0);
  }
  step.external = external_forces(model, loads);
  FemBalance& balance = step.balance;
  balance.scale = 1.0 - c.force_share;
  balance.time_step = dt;
  balance.matrix = &matrix_;
  // `matrix` takes x', not x' - x.
  balance.offset =
      mass_times((1.0 - c.mass_share) * (step.a0 - c.acceleration * state.x) + c.mass_share * state.acceleration);
  if (is_damped_)
    balance.offset +=
        damping_times((1.0 - c.force_share) * (step.v0 - c.velocity * state.x) + c.force_share * state.velocity);
  balance.offset += c.force_share * state.force - balance.scale * step.external;
  return step;
}

// force: what the terms balance at x, less the external forces.
void FemDynamics::arrive(const Step& step, const Eigen::VectorXd& x, Eigen::VectorXd force, double dt,
                         FemState& state) const {
  const Eigen::VectorXd moved = x - state.x;
  state.x = x;
  state.acceleration = step.c.acceleration * moved + step.a0;
  state.velocity = step.c.velocity * moved + step.v0;
  state.force = std::move(force);
  state.reaction = mass_times(state.acceleration) + state.force;
  if (is_damped_) state.reaction += damping_times(state.velocity);
  state.pressed = equilibrium_->pressed(state.x, dt, state.history);
  equilibrium_->accept(state.x, dt, state.history);
}

FemReport FemDynamics::step(FemState& state, const FemLoads& loads, double dt, const FemControl& control) {
  prepare(dt);
  const Step step = step_from(state, loads, dt);
  const FemHold hold = hold_of(equilibrium_->model(), loads.pads);
  Eigen::VectorXd x = state.x, force;
  const FemReport report = equilibrium_->find(step.balance, hold, state.history, control, x);
  if (!report.converged) return report;
  state.hold = hold;
  equilibrium_->terms(x, dt, state.history, force);
  arrive(step, x, force - step.external, dt, state);
  return report;
}

std::optional<FemDynamics::Guide> FemDynamics::guide(const FemState& before, const FemState& after,
                                                     const FemLoads& loads, double dt) {
  prepare(dt);
  const Step step = step_from(before, loads, dt);
  if (!equilibrium_->factor_at(step.balance, after.x, before.history, after.hold)) return std::nullopt;
  return Guide{after.x, equilibrium_->unbalanced(step.balance, after.x, before.history)};
}

void FemDynamics::follow(const Guide& guide, FemState& state, const FemLoads& loads, double dt) {
  sum_matrix(dt);
  const Step step = step_from(state, loads, dt);
  const FemBalance& balance = step.balance;
  state.hold = hold_of(equilibrium_->model(), loads.pads);
  const Eigen::VectorXd more = equilibrium_->unbalanced(balance, guide.x, state.history) - guide.unbalanced;
  const Eigen::VectorXd x = guide.x - equilibrium_->factor().solve(more);
  // What the terms have to be there for the balance to be out by as much as the guide's; at held nodes they are not.
  Eigen::VectorXd force;
  if (loads.pads.empty()) {
    equilibrium_->model().pattern().multiply(matrix_, x, force);
    force = (guide.unbalanced - balance.offset - force) / balance.scale;
  } else {
    equilibrium_->terms(x, dt, state.history, force);
  }
  arrive(step, x, force - step.external, dt, state);
}

double FemDynamics::kinetic_energy(const FemState& state) const {
  return 0.5 * state.velocity.dot(mass_times(state.velocity));
}

}  // namespace tissued::core
