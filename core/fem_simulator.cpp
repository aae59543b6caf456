#include "core/fem_simulator.hpp"

#include <omp.h>

#include <algorithm>
#include <exception>

#include "core/effects/effect.hpp"
#include "core/state_hash.hpp"

namespace tissued::core {

namespace {

constexpr double kTolerance = 1e-6;  // mm, where none was asked for

int threads_of(int requested) { return requested > 0 ? requested : std::clamp(omp_get_num_procs(), 1, 8); }

std::vector<FemEffect> fem_effects(const std::vector<EffectSetting>& settings) {
  std::vector<FemEffect> effects;
  for (const EffectSetting& setting : settings) effects.push_back(fem_effect(*setting.effect));
  return effects;
}

// Fields that vary inside of an element want more points than the standard rule has.
int quadrature_of(const SimulatorOptions& options) {
  constexpr int kUsual = 0, kFine = 5;
  return options.effects.empty() || options.fem.element == FemElement::p1 ? kUsual : kFine;
}

double furthest_held(const FemState& state) {
  double furthest = 0.0;
  for (std::size_t i = 0; i < state.hold.held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (state.hold.held[i])
      furthest = std::max(furthest, (state.hold.position.segment<3>(at) - state.x.segment<3>(at)).norm());
  }
  return furthest;
}

}  // namespace

FemSimulator::FemSimulator(const Scene& scene, const SimulatorOptions& options)
    : model_(adjusted(scene, options.effects), FemOptions{options.fem.element, quadrature_of(options),
                                                          MassMatrix::consistent, fem_effects(options.effects)}),
      equilibrium_(model_, threads_of(options.solver.threads)),
      rest_(model_.rest()),
      time_step_(options.solver.time_step) {
  for (const EffectSetting& setting : options.effects) set_effect(model_, *setting.effect, setting.values);
  control_.tolerance = options.solver.tolerance > 0.0 ? options.solver.tolerance : kTolerance;
  if (options.fem.dynamics) dynamics_.emplace(equilibrium_, *options.fem.dynamics, options.fem.damping);
  reset();
}

void FemSimulator::reset() {
  state_ = rest_state(model_);
  equilibrium_.forget_factor();
  // Under its own weight, before anything is recorded.
  if (!model_.scene().gravity.isZero()) {
    const std::vector<PadInput> lifted(model_.scene().pads.size());
    solve_static(equilibrium_, state_, {lifted, nullptr}, control_, 0.0);
  }
  publish({});
}

void FemSimulator::publish(std::span<const PadInput> pads) {
  positions_.setZero(model_.mesh().corner_count, 4);
  for (int i = 0; i < model_.mesh().corner_count; ++i)
    positions_.row(i).head<3>() = state_.x.segment<3>(3 * i).transpose();
  pad_forces_ = pad_forces(state_, pads);
  pad_forces_.resize(model_.scene().pads.size(), Vec3::Zero());
}

FemReport FemSimulator::advance(const Observation& observation) {
  const FemLoads loads{observation.pads, nullptr};
  if (dynamics_) return dynamics_->step(state_, loads, observation.dt, control_);
  return solve_static(equilibrium_, state_, loads, control_, observation.dt);
}

StepReport FemSimulator::step(const Observation& observation) noexcept {
  StepReport report;
  try {
    const FemReport solved = advance(observation);
    publish(observation.pads);
    report.iterations = solved.corrections;
    report.dual_residual = solved.correction;
    report.converged = solved.converged;
    report.pad_ramp = solved.converged ? 0.0 : furthest_held(state_);
  } catch (const std::exception&) {
    // Out of memory: the state is the last one that was published.
    equilibrium_.forget_factor();
  }
  return report;
}

TargetEstimate FemSimulator::target(int index) const noexcept {
  const FemPoint& point = model_.target_points()[static_cast<std::size_t>(index)];
  return {model_.scene().targets[static_cast<std::size_t>(index)].rest + position_of(point, state_.x) -
              position_of(point, rest_),
          Mat3::Zero()};
}

Vec3 FemSimulator::marker(int index) const noexcept {
  const FemPoint& point = model_.marker_points()[static_cast<std::size_t>(index)];
  return model_.scene().markers[static_cast<std::size_t>(index)].rest + position_of(point, state_.x) -
         position_of(point, rest_);
}

std::uint64_t FemSimulator::state_hash() const noexcept {
  StateHash hash;
  for (const Eigen::VectorXd* part : {&state_.x, &state_.velocity, &state_.acceleration})
    hash.mix(part->data(), part->size());
  return hash.value();
}

}  // namespace tissued::core
