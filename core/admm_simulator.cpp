#include "core/admm_simulator.hpp"

#include <algorithm>
#include <cmath>

#include "core/state_hash.hpp"

namespace tissued::core {

namespace {

constexpr double kPadLimit = 3.0;     // mm a held node may move in one step; a larger jump of a pad or probe is ramped
constexpr double kSettledMove = 0.1;  // mm; what `converged` means, however early iterations may end
constexpr int kAllModesUpTo = 1200;   // free nodes; beyond, the dense eigenproblem takes minutes
constexpr int kModesOfLargeMesh = 300;

// Iterations after which laws are evaluated anew: they cost as much as several local steps and change little in one. A
// damping stress must follow every move.
int effects_every(const Enrichment& enrichment) { return enrichment.damping().stiffness > 0.0 ? 1 : 3; }

int modes_for(const Model& model, int requested) {
  if (requested > 0) return requested;
  return model.system().free_count() <= kAllModesUpTo ? 0 : kModesOfLargeMesh;
}

}  // namespace

AdmmSimulator::AdmmSimulator(const Scene& scene, const SimulatorOptions& options, bool closed_loop)
    : options_(options), closed_loop_(closed_loop) {
  if (!options.effects.empty()) {
    enrichment_ = std::make_unique<Enrichment>(scene, options.effects);
    effects_every_ = effects_every(*enrichment_);
  }
  build(enrichment_ ? enrichment_->scene() : scene, options.solver.time_step);
  settle();
}

void AdmmSimulator::build(const Scene& scene, double time_step) {
  time_step_ = time_step;
  auto model = std::make_unique<Model>(scene, options_.solver.element, options_.solver.weight_scale,
                                       time_step / steps_per_frame(), enrichment_.get());
  filter_.reset();
  workspace_.reset();
  model_ = std::move(model);
  workspace_.emplace(*model_, resolve_threads(options_.solver.threads, scene.mesh.tet_count()));
  if (!state_) state_.emplace(*model_);
  if (enrichment_ && !effects_) effects_.emplace(*enrichment_, *model_);
  if (closed_loop_ && options_.filter.preset == NoisePreset::standard) {
    if (stiffness_filter_) {
      stiffness_filter_->use(*model_);
    } else {
      stiffness_filter_.emplace(*model_, options_.filter);
    }
    if (options_.alarm.enabled && !watch_) start_watch();
  } else if (closed_loop_) {
    if (!basis_)
      basis_ = modal_basis(model_->laplacian(), model_->masses(), model_->system().free_nodes(),
                           modes_for(*model_, options_.filter.modes));
    filter_.emplace(*model_, *basis_, options_.filter);
  }
  const std::size_t markers = model_->scene().markers.size();
  if (!history_) history_.emplace(markers);
  simulated_.assign(markers, Vec3::Zero());
  markers_now_.assign(markers, Vec3::Zero());
  marker_seen_.assign(markers, 0);
  last_finite_ = state_->x;
  pad_forces_.assign(model_->scene().pads.size(), Vec3::Zero());
  probe_forces_.assign(model_->scene().probes.size(), Vec3::Zero());
  lifted_.assign(model_->scene().pads.size(), PadInput{});
}

int AdmmSimulator::steps_per_frame() const {
  return options_.solver.scheme == Scheme::algorithm_1 ? options_.solver.iterations : 1;
}

void AdmmSimulator::set_time_step(double time_step) {
  const Scene scene = model_->scene();
  build(scene, time_step);
}

void AdmmSimulator::reset() {
  state_->reset(*model_);
  workspace_->release_pads();
  workspace_->contact.forget();
  if (effects_) effects_->reset();
  settle();
  for (Vec3& force : pad_forces_) force.setZero();
  for (Vec3& force : probe_forces_) force.setZero();
  history_->clear();
  if (filter_) filter_->reset();
  if (stiffness_filter_) stiffness_filter_->reset();
  if (!watch_) return;
  watch_->alarm.reset();
  watch_->learnt.reset();
  watch_->place.reset();
}

// Under its own weight, before anything is recorded.
void AdmmSimulator::settle() {
  constexpr int kMostIterations = 3000;
  constexpr double kSettled = 1e-4;  // mm, of a node in an iteration
  if (!model_->acceleration().isZero()) {
    begin_step(*model_, *state_, *workspace_, lifted_, kQuasiStatic, kPadLimit);
    double move = 1.0;
    for (int k = 0; k < kMostIterations && move > kSettled; ++k) move = iterate_once(lifted_, kQuasiStatic, 0.0, true);
    state_->x_previous = state_->x;
  }
  last_finite_ = state_->x;
}

// Returns the largest move of a node, mm. effect_time: s that laws with a memory see pass. anew: their forces are
// evaluated, else those of an earlier iteration stay.
double AdmmSimulator::iterate_once(std::span<const PadInput> pads, double dt, double effect_time, bool anew,
                                   LocalStepResult* local) {
  AdmmState& state = *state_;
  const LocalStepResult result =
      local_stage(*model_, state, *workspace_, effects_ ? effects_->deformations().data() : nullptr);
  if (local != nullptr) *local = result;
  if (!effects_) return global_stage(*model_, state, *workspace_, dt);
  if (anew) effects_->evaluate(*model_, state.domains, state.x, pads, effect_time, workspace_->threads);
  effects_->add_stresses(*model_, workspace_->forces, workspace_->threads);
  return global_stage(*model_, state, *workspace_, dt, &effects_->node_forces());
}

StepReport AdmmSimulator::step(const Observation& observation) noexcept {
  StepReport report;
  report.finite = std::all_of(observation.probes.begin(), observation.probes.end(), is_sound);
  if (!report.finite) return report;
  solve(observation, report);
  report.penetration = workspace_->contact.penetration(state_->x);
  report.converged = std::max({report.primal_residual, report.dual_residual, report.penetration}) <=
                     std::max(options_.solver.tolerance, kSettledMove);
  report.finite = !report.braked && state_is_finite();
  if (report.finite) {
    last_finite_ = state_->x;
    if (effects_) effects_->keep();
    read_pad_forces(observation.pads);
  } else {
    hold_last_finite();
  }
  return report;
}

// Ends where the state is lost or the brake is pulled: the filters learn nothing from that.
void AdmmSimulator::solve(const Observation& observation, StepReport& report) {
  const int frames = std::clamp(static_cast<int>(std::lround(observation.dt / time_step_)), 1, 20);
  if (options_.solver.scheme == Scheme::per_frame) {
    const int most = options_.solver.iterations;
    iterate(observation, observation.dt,
            observation.max_iterations > 0 ? std::min(observation.max_iterations, most) : most, report);
    if (report.braked || !state_is_finite()) return;
    bring_forward(observation, report);
    correct(observation, observation.dt, frames, report);
    return;
  }
  // Algorithm 1 as printed: n counts iterations and time steps at once. The frame's time is shared out over its n, so
  // that simulated and measured time agree; its markers and pads stay. It knows no gaps: every n is one step of the
  // covariance, or a lost frame would unsettle a gain that needs hundreds of these short steps to settle again.
  for (int n = 0; n < steps_per_frame(); ++n) {
    iterate(observation, observation.dt / steps_per_frame(), 1, report);
    if (report.braked || !state_is_finite()) return;
    if (n == 0) bring_forward(observation, report);
    correct(observation, observation.dt / steps_per_frame(), 1, report);
  }
}

// The last good answer; duals and velocity start again from it. What was learnt, and what laws remember, stays.
void AdmmSimulator::hold_last_finite() {
  state_->reset(*model_);
  state_->x = last_finite_;
  state_->x_previous = last_finite_;
  if (stiffness_filter_) stiffness_filter_->apply(*state_);
  workspace_->held.forget_forces();
  workspace_->contact.forget();
  if (effects_) effects_->restore();
  if (filter_) filter_->reset();
  if (watch_) watch_->alarm.reset();
}

void AdmmSimulator::iterate(const Observation& observation, double dt, int iterations, StepReport& report) {
  AdmmState& state = *state_;
  // The factor's inertia must not be far below the residual's, or the iteration overshoots: see global_step.hpp.
  constexpr double kShortest = 0.75;
  dt = std::max(dt, kShortest * model_->time_step());
  report.pad_ramp = begin_step(*model_, state, *workspace_, observation.pads, dt, kPadLimit);
  report.pad_ramp = std::max(report.pad_ramp, begin_contact(state, *workspace_, observation.probes, kPadLimit));
  // First guess of x_{n+1}: most of the motion goes on. A few iterations from x_n leave the smooth, slow part of the
  // answer behind the pads.
  constexpr double kGoesOn = 0.85;
  const double extrapolate = options_.solver.scheme == Scheme::per_frame ? kGoesOn * dt / state.dt : 0.0;
  state.x_previous.swap(state.x);  // x_{n-1} <- x_n
  state.x = state.x_previous + extrapolate * (state.x_previous - state.x);
  for (int k = 0; k < iterations; ++k) {
    report.braked = observation.brake.pulled();
    if (report.braked) return;
    LocalStepResult local;
    report.dual_residual = iterate_once(observation.pads, dt, dt, k % effects_every_ == 0, &local);
    report.primal_residual = local.primal;
    report.inverted = local.inverted;
    ++report.iterations;
    if (std::max(report.primal_residual, report.dual_residual) < options_.solver.tolerance) break;
  }
  if (effects_) effects_->accept(state.x, observation.pads, dt, workspace_->threads);
  report.contacts = workspace_->contact.pressed();
  for (std::size_t p = 0; p < probe_forces_.size(); ++p)
    probe_forces_[p] = workspace_->contact.force(static_cast<int>(p));
  state.dt = dt;
}

void AdmmSimulator::read_pad_forces(std::span<const PadInput> pads) {
  pad_forces(*workspace_, pad_forces_);
  if (effects_) effects_->add_pad_forces(pads, pad_forces_);
}

// Markers that are older than the pads go on as the simulation has since.
void AdmmSimulator::bring_forward(const Observation& observation, StepReport& report) {
  if (!closed_loop_) return;
  for (std::size_t i = 0; i < simulated_.size(); ++i) simulated_[i] = marker(static_cast<int>(i));
  history_->add(simulated_, observation.dt);
  marker_seen_ = observation.marker_seen;
  if (!history_->moved_since(observation.marker_age, markers_now_)) {
    for (std::uint8_t& seen : marker_seen_) {
      report.markers_too_late += seen != 0 ? 1 : 0;
      seen = 0;
    }
  }
  for (std::size_t i = 0; i < markers_now_.size(); ++i) markers_now_[i] += observation.markers[i];
}

void AdmmSimulator::correct(const Observation& observation, double dt, int frames, StepReport& report) {
  Innovation innovation;
  if (filter_)
    innovation =
        filter_->correct(markers_now_, marker_seen_, workspace_->held_pads(), frames, state_->x, state_->x_previous);
  if (filter_) restore_contact(*model_, *state_, *workspace_);
  if (stiffness_filter_) {
    read_pad_forces(observation.pads);
    const double pressed = workspace_->contact.travel(state_->x, model_->rest());
    innovation =
        stiffness_filter_->correct(markers_now_, marker_seen_, observation.pads, pad_forces_, pressed, dt, *state_);
    if (watch_) watch(observation, dt, report);
  }
  report.markers_used = innovation.markers_used;
  report.markers_swapped = innovation.markers_swapped;
  report.innovation_rms = innovation.rms;
}

void AdmmSimulator::start_watch() {
  const std::vector<Vec3> none(model_->marker_points().size(), Vec3::Zero());
  AlarmOptions options = options_.alarm;
  RestCompliance compliance = stiffness_filter_->compliance();
  const ElementError error(*model_, compliance);
  // Nothing is known of the elements' own error on such a mesh.
  constexpr double kUnknownElements = 3.0;
  if (!error.known()) options.model_error *= kUnknownElements;
  watch_.emplace(Watch{MismatchAlarm(options, none.size(), model_->scene().marker_noise), LearntShift(*model_),
                       MismatchPlace(*model_), error, none, none});
}

void AdmmSimulator::watch(const Observation& observation, double dt, StepReport& report) {
  const StiffnessFilter& filter = *stiffness_filter_;
  if (filter.has_learnt()) watch_->learnt.advance(*model_, filter.compliance(), *state_);
  MismatchFrame frame;
  frame.dt = dt;
  frame.innovation = filter.innovation();
  for (std::size_t i = 0; i < watch_->misfit.size(); ++i) {
    const auto marker = static_cast<int>(i);
    watch_->elements[i] = watch_->error.at(marker, observation.pads);
    watch_->misfit[i] = filter.innovation()[i] + watch_->learnt.at_marker(marker) - watch_->elements[i];
  }
  frame.misfit = watch_->misfit;
  frame.elements = watch_->elements;
  frame.used = filter.used();
  frame.moved = filter.moved();
  for (std::size_t pad = 0; pad < observation.pads.size(); ++pad) {
    const PadInput& input = observation.pads[pad];
    if (input.kind == PadInput::Kind::force) frame.by_force = true;
    if (input.kind == PadInput::Kind::pose)
      frame.pad_travel = std::max(frame.pad_travel, (input.center - model_->scene().pads[pad].center).norm());
  }
  frame.place_sd = observation.marker_place_sd;
  // What the elements' own error is under a probe is not known.
  frame.sound = report.contacts == 0 && report.pad_ramp == 0.0 &&
                std::max(report.primal_residual, report.dual_residual) <= kSettledMove && state_is_finite();
  const double evidence = watch_->alarm.see(frame);
  if (evidence > 0.0) watch_->place.add(watch_->alarm.misfit(), watch_->alarm.judged(), evidence);
  watch_->place.advance(filter.compliance());
  report.mismatch = watch_->alarm.report();
  if (report.mismatch.level == 0.0) watch_->place.reset();
  report.mismatch.has_place = watch_->place.known();
  if (report.mismatch.has_place) report.mismatch.place = watch_->place.place();
}

bool AdmmSimulator::state_is_finite() const { return state_->x.allFinite() && state_->x_previous.allFinite(); }

TargetEstimate AdmmSimulator::target(int index) const noexcept {
  TargetEstimate estimate;
  const MaterialPoint& point = model_->target_points()[static_cast<std::size_t>(index)];
  estimate.position = position_of(point, state_->x) - rest_position(model_->scene().mesh, point) +
                      model_->scene().targets[static_cast<std::size_t>(index)].rest;
  if (filter_) estimate.covariance = filter_->target_variance(index) * Mat3::Identity();
  if (stiffness_filter_) {
    estimate.position += stiffness_filter_->target_shift(index);
    estimate.covariance = stiffness_filter_->target_covariance(index);
  }
  return estimate;
}

Vec3 AdmmSimulator::marker(int index) const noexcept {
  const MaterialPoint& point = model_->marker_points()[static_cast<std::size_t>(index)];
  return position_of(point, state_->x) - rest_position(model_->scene().mesh, point) +
         model_->scene().markers[static_cast<std::size_t>(index)].rest;
}

std::uint64_t AdmmSimulator::state_hash() const noexcept {
  StateHash hash;
  hash.mix(state_->x.data(), state_->x.size());
  hash.mix(state_->x_previous.data(), state_->x_previous.size());
  for (const DomainState& domain : state_->domains) hash.mix(&domain.u[0][0], 9 * kLanes);
  if (effects_) hash.mix(effects_->history().data(), static_cast<Eigen::Index>(effects_->history().size()));
  return hash.value();
}

}  // namespace tissued::core
