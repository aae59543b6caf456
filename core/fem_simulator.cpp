#include "core/fem_simulator.hpp"

#include <omp.h>

#include <algorithm>
#include <exception>

#include "core/effects/effect.hpp"
#include "core/state_hash.hpp"

namespace tissued::core {

namespace {

constexpr double kTolerance = 1e-6;         // mm, where none was asked for
constexpr double kContactTolerance = 5e-4;  // mm, by which contact may be violated

int threads_of(int requested) { return requested > 0 ? requested : std::clamp(omp_get_num_procs(), 1, 8); }

// contact: where the term of the probes is, for whoever moves them; null where there are none.
std::vector<FemEffect> fem_effects(const std::vector<EffectSetting>& settings, FemProbeContact*& contact) {
  std::vector<FemEffect> effects;
  for (const EffectSetting& setting : settings) effects.push_back(fem_effect(*setting.effect));
  effects.emplace_back([&contact](const Scene& scene, const FemMesh& mesh, FemPhysics& physics) {
    if (scene.probes.empty()) return;
    auto term = std::make_unique<FemProbeContact>(scene, mesh, physics.fixed_nodes);
    contact = term.get();
    physics.terms.push_back(std::move(term));
  });
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
    : model_(adjusted(scene, options.effects),
             FemOptions{options.fem.element, quadrature_of(options), MassMatrix::consistent,
                        fem_effects(options.effects, contact_)}),
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
  if (contact_ != nullptr) contact_->lift();
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
  probe_forces_.assign(model_.scene().probes.size(), Vec3::Zero());
  for (std::size_t p = 0; p < probe_forces_.size(); ++p) probe_forces_[p] = contact_->force(static_cast<int>(p));
}

FemReport FemSimulator::advance(const Observation& observation, double dt) {
  const FemLoads loads{observation.pads, nullptr};
  if (dynamics_) return dynamics_->step(state_, loads, dt, control_);
  return solve_static(equilibrium_, state_, loads, control_, dt);
}

// The probes where they are: solved again from the same past until the multipliers have settled.
FemReport FemSimulator::solve_contact(const Observation& observation, double dt) {
  constexpr int kMostUpdates = 200;
  const double settled = std::max(control_.tolerance, kContactTolerance);
  const FemState before = state_;
  FemReport report;
  for (int k = 0; k < kMostUpdates; ++k) {
    if (k > 0 && dynamics_) state_ = before;
    if (k > 0 && !dynamics_) state_.history = before.history;
    if (k == 0) equilibrium_.forget_factor();
    const FemReport solved = advance(observation, dt);
    const int corrections = report.corrections + solved.corrections;
    report = solved;
    report.corrections = corrections;
    if (!report.converged || contact_->update(state_.x) < settled) return report;
  }
  report.converged = false;
  return report;
}

// Quasi-static, the probes come in by small steps in which no time passes; the last one has the frame's.
FemReport FemSimulator::press(const Observation& observation, double& ahead) {
  constexpr double kStep = 1.0;  // mm
  contact_->release(hold_of(model_, observation.pads).held);
  for (;;) {
    ahead = contact_->follow(observation.probes, state_.x, kStep);
    const bool is_last = ahead == 0.0 || dynamics_.has_value();
    const FemReport report = solve_contact(observation, is_last ? observation.dt : 0.0);
    if (is_last || !report.converged) return report;
  }
}

StepReport FemSimulator::step(const Observation& observation) noexcept {
  StepReport report;
  report.finite = std::all_of(observation.probes.begin(), observation.probes.end(), is_sound);
  if (!report.finite) return report;
  try {
    double ahead = 0.0;
    const FemReport solved = contact_ != nullptr ? press(observation, ahead) : advance(observation, observation.dt);
    publish(observation.pads);
    report.iterations = solved.corrections;
    report.dual_residual = solved.correction;
    report.converged = solved.converged;
    report.pad_ramp = std::max(ahead, solved.converged ? 0.0 : furthest_held(state_));
    if (contact_ != nullptr) {
      report.contacts = contact_->pressed();
      report.penetration = contact_->penetration(state_.x);
    }
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
