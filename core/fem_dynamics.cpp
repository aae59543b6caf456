#include "core/fem_dynamics.hpp"

#include <cmath>

namespace tissued::core {

FemDynamics::FemDynamics(FemEquilibrium& equilibrium, const TimeScheme& scheme, const RayleighDamping& damping)
    : equilibrium_(&equilibrium), scheme_(scheme), rates_(damping) {
  if (!(scheme.spectral_radius >= 0.0 && scheme.spectral_radius <= 1.0))
    throw ModelError("the spectral radius of generalized-alpha must be within 0 and 1");
  if (!(damping.mass >= 0.0 && damping.stiffness >= 0.0)) throw ModelError("Rayleigh damping must not be negative");
  refresh();
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
  for (std::size_t k = 0; k < damping_.size(); ++k)
    damping_[k] = (rates_.mass + own.mass) * mass_[k] + (rates_.stiffness + own.stiffness) * damping_[k];
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
  if (dt == dt_) return;
  dt_ = dt;
  const Coefficients c = coefficients(dt);
  for (std::size_t k = 0; k < matrix_.size(); ++k)
    matrix_[k] = (1.0 - c.mass_share) * c.acceleration * mass_[k] + (1.0 - c.force_share) * c.velocity * damping_[k];
  equilibrium_->forget_factor();
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

FemReport FemDynamics::step(FemState& state, const FemLoads& loads, double dt, const FemControl& control) {
  prepare(dt);
  const FemModel& model = equilibrium_->model();
  const Coefficients c = coefficients(dt);
  // a' = acceleration (x' - x) + a0, v' = velocity (x' - x) + v0.
  Eigen::VectorXd a0 = -state.velocity / dt, v0 = Eigen::VectorXd::Zero(state.x.size());
  if (scheme_.kind == TimeScheme::Kind::generalized_alpha) {
    const double gamma = c.velocity / (c.acceleration * dt), inverse_beta = c.acceleration * dt * dt;
    a0 = -inverse_beta / dt * state.velocity - (0.5 * inverse_beta - 1.0) * state.acceleration;
    v0 = state.velocity + dt * ((1.0 - gamma) * state.acceleration + gamma * a0);
  }
  const Eigen::VectorXd external = external_forces(model, loads);
  FemBalance balance;
  balance.scale = 1.0 - c.force_share;
  balance.time_step = dt;
  balance.matrix = &matrix_;
  model.pattern().multiply(matrix_, -state.x, balance.offset);
  balance.offset += mass_times((1.0 - c.mass_share) * a0 + c.mass_share * state.acceleration);
  balance.offset += damping_times((1.0 - c.force_share) * v0 + c.force_share * state.velocity);
  balance.offset += c.force_share * state.force - balance.scale * external;

  const FemHold hold = hold_of(model, loads.pads);
  Eigen::VectorXd x = state.x;
  FemReport report = equilibrium_->find(balance, hold, state.history, control, x);
  if (!report.converged) return report;
  const Eigen::VectorXd moved = x - state.x;
  state.x = x;
  state.acceleration = c.acceleration * moved + a0;
  state.velocity = c.velocity * moved + v0;
  state.hold = hold;
  equilibrium_->terms(state.x, dt, state.history, state.force);
  state.force -= external;
  state.reaction = mass_times(state.acceleration) + damping_times(state.velocity) + state.force;
  state.pressed = equilibrium_->pressed(state.x, dt, state.history);
  equilibrium_->accept(state.x, dt, state.history);
  return report;
}

double FemDynamics::kinetic_energy(const FemState& state) const {
  return 0.5 * state.velocity.dot(mass_times(state.velocity));
}

}  // namespace tissued::core
