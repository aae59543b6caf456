#include "core/pbd_simulator.hpp"

#include <algorithm>
#include <cmath>

#include "core/state_hash.hpp"

namespace tissued::core {

namespace {

constexpr int kMostTimeSteps = 5;     // that one frame brings
constexpr double kSettledMove = 0.1;  // mm; what `converged` means, as for the other simulators

bool is_finite(const PadInput& pad) {
  if (pad.kind == PadInput::Kind::pose) return pad.center.allFinite() && pad.rotation.allFinite();
  return pad.kind == PadInput::Kind::absent || pad.force.allFinite();
}

bool is_sound(const Observation& observation) {
  return std::isfinite(observation.dt) &&
         std::ranges::all_of(observation.pads, [](const PadInput& pad) { return is_finite(pad); }) &&
         std::ranges::all_of(observation.probes, [](const ProbeInput& probe) { return core::is_sound(probe); });
}

}  // namespace

PbdState::PbdState(const PbdModel& model)
    : x(model.rest),
      v(NodeField::Zero(model.rest.rows(), 4)),
      clusters(model.clusters),
      probes(model.scene.probes.size()) {}

PbdSimulator::PbdSimulator(const Scene& scene, const SimulatorOptions& options)
    : model_(scene, options.pbd),
      state_(model_),
      time_step_(options.solver.time_step),
      last_finite_(model_.rest),
      before_(model_.rest),
      start_(model_.rest),
      mobility_(model_.mobility),
      pad_of_(mobility_.size(), -1),
      pose_changes_(scene.probes.size()),
      positions_(NodeField::Zero(scene.mesh.node_count(), 4)) {
  for (const Probe& probe : scene.probes)
    contacts_.emplace_back(probe.shape, options.pbd.collision_distance, options.pbd.particle_spacing,
                           options.pbd.shape_friction, mobility_.size());
  if (options.pbd.self_collision) self_collision_.emplace(model_.lattice, options.pbd.particle_friction);
  settle();
  reset();
}

// Under its own weight, before anything is recorded.
void PbdSimulator::settle() {
  constexpr int kMostSteps = 500;
  constexpr double kSettled = 1e-3;  // mm, of a particle in a time step
  Observation lifted;
  lifted.resize_for(model_.scene);
  double move = model_.gravity.isZero() ? 0.0 : 1.0;
  for (int n = 0; n < kMostSteps && move > kSettled; ++n) {
    hanging_ = state_.x;
    StepReport ignored;
    for (int k = 0; k < model_.options.substeps; ++k) substep(lifted, 1.0, ignored);
    move = (state_.x - hanging_).rowwise().norm().maxCoeff();
  }
  hanging_ = state_.x;
}

void PbdSimulator::reset() {
  last_finite_ = hanging_;
  hold_last_finite();
  publish();
}

// Without speed, as a body that has only just been put there.
void PbdSimulator::hold_last_finite() {
  state_.x = last_finite_;
  state_.v.setZero();
  state_.clusters.reset();
  state_.owed = 0.0;
  std::fill(state_.probes.begin(), state_.probes.end(), ProbeInput{});
}

void PbdSimulator::publish() {
  for (int i = 0; i < model_.nodes.count(); ++i)
    positions_.row(i).head<3>() =
        (model_.scene.mesh.node(i) + model_.nodes.displacement(i, model_.rest, state_.x)).transpose();
}

StepReport PbdSimulator::step(const Observation& observation) noexcept {
  StepReport report;
  report.finite = is_sound(observation);
  if (!report.finite) return report;
  take_pads(observation.pads);
  const int due = substeps_due(observation.dt);
  for (int k = 0; k < due; ++k) substep(observation, 1.0 / (due - k), report);
  report.finite = state_is_finite();
  if (report.finite) {
    last_finite_ = state_.x;
  } else {
    hold_last_finite();
  }
  report.converged = report.finite && report.dual_residual <= kSettledMove;
  publish();
  return report;
}

int PbdSimulator::substeps_due(double dt) {
  constexpr double kRounding = 1e-6;  // substeps
  const double substep = model_.options.substep();
  const double most = kMostTimeSteps * model_.options.time_step;
  state_.owed = std::min(state_.owed + std::max(dt, 0.0), most);
  const int due = static_cast<int>(std::floor(state_.owed / substep + kRounding));
  state_.owed = std::max(0.0, state_.owed - due * substep);
  return due;
}

// A particle of two pads follows the first.
void PbdSimulator::take_pads(std::span<const PadInput> pads) {
  mobility_ = model_.mobility;
  std::fill(pad_of_.begin(), pad_of_.end(), -1);
  for (std::size_t pad = pads.size(); pad-- > 0;) {
    if (pads[pad].kind != PadInput::Kind::pose) continue;
    for (int i : model_.pad_particles[pad]) {
      mobility_[static_cast<std::size_t>(i)] = 0.0;
      pad_of_[static_cast<std::size_t>(i)] = static_cast<int>(pad);
    }
  }
}

// share: of the way to the frame's poses that this substep goes.
void PbdSimulator::substep(const Observation& observation, double share, StepReport& report) {
  start_ = state_.x;
  predict(observation.pads);
  move_pads(observation.pads, share);
  move_probes(observation.probes, share);
  if (self_collision_) self_collision_->find(state_.x);
  for (int k = 0; k < model_.options.iterations; ++k) {
    before_ = state_.x;
    report.contacts = iterate();
  }
  report.penetration = 0.0;
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (state_.probes[i].seen)
      report.penetration = std::max(report.penetration, contacts_[i].penetration(pose_changes_[i], state_.x));
  report.dual_residual = (state_.x - before_).rowwise().norm().maxCoeff();
  report.iterations += model_.options.iterations;
  state_.v = (state_.x - start_) / model_.options.substep();
}

// Symplectic Euler: v += h (a - c v), x += h v.
void PbdSimulator::predict(std::span<const PadInput> pads) {
  const double h = model_.options.substep();
  NodeField& v = state_.v;
  v *= 1.0 - h * model_.options.damping;
  v.rowwise() += h * model_.gravity;
  for (std::size_t pad = 0; pad < pads.size(); ++pad) {
    if (pads[pad].kind != PadInput::Kind::force) continue;
    const std::vector<int>& pushed = model_.pad_particles[pad];
    const double mass = model_.particle_mass * static_cast<double>(pushed.size());
    const Vec3 change = h * kMillinewtonPerNewton / mass * pads[pad].force;
    for (int i : pushed) v.row(i).head<3>() += change.transpose();
  }
  for (Eigen::Index i = 0; i < v.rows(); ++i) state_.x.row(i) += h * mobility_[static_cast<std::size_t>(i)] * v.row(i);
}

void PbdSimulator::move_pads(std::span<const PadInput> pads, double share) {
  for (std::size_t pad = 0; pad < pads.size(); ++pad) {
    if (pads[pad].kind != PadInput::Kind::pose) continue;
    for (int i : model_.pad_particles[pad]) {
      if (pad_of_[static_cast<std::size_t>(i)] != static_cast<int>(pad)) continue;
      const Vec3 goal =
          pads[pad].center + pads[pad].rotation * (model_.lattice.rest(i) - model_.scene.pads[pad].center);
      const Vec3 from = state_.x.row(i).head<3>().transpose();
      state_.x.row(i).head<3>() = ((1.0 - share) * from + share * goal).transpose();
    }
  }
}

// A probe that was not seen before is where it is seen at once.
void PbdSimulator::move_probes(std::span<const ProbeInput> probes, double share) {
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    ProbeInput& now = state_.probes[i];
    const RigidTransform& goal = probes[i].tissue_T_probe;
    PoseChange& motion = pose_changes_[i];
    motion.begin = now.seen ? now.tissue_T_probe : goal;
    motion.end = now.seen && share < 1.0 ? interpolate(motion.begin, goal, share) : goal;
    now.seen = probes[i].seen;
    now.tissue_T_probe = motion.end;
    if (now.seen) contacts_[i].find(motion, mobility_, state_.x);
  }
}

// Gauss-Seidel over the kinds of constraints; contact with probes has the last word.
int PbdSimulator::iterate() {
  int pushes = 0;
  match_shapes(model_.clusters, model_.options.cluster_stiffness, mobility_, state_.x, state_.clusters);
  if (self_collision_) self_collision_->resolve(mobility_, start_, state_.x);
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    if (state_.probes[i].seen) pushes += contacts_[i].resolve(pose_changes_[i], start_, state_.x);
  return pushes;
}

bool PbdSimulator::state_is_finite() const { return state_.x.allFinite() && state_.v.allFinite(); }

TargetEstimate PbdSimulator::target(int index) const noexcept {
  return {model_.scene.targets[static_cast<std::size_t>(index)].rest +
              model_.targets.displacement(index, model_.rest, state_.x),
          Mat3::Zero()};
}

Vec3 PbdSimulator::marker(int index) const noexcept {
  return model_.scene.markers[static_cast<std::size_t>(index)].rest +
         model_.markers.displacement(index, model_.rest, state_.x);
}

std::uint64_t PbdSimulator::state_hash() const noexcept {
  StateHash hash;
  hash.mix(state_.x.data(), state_.x.size());
  hash.mix(state_.v.data(), state_.v.size());
  for (const Eigen::Quaterniond& rotation : state_.clusters.rotation) hash.mix(rotation.coeffs().data(), 4);
  hash.mix(&state_.owed, 1);
  for (const ProbeInput& probe : state_.probes) {
    const double seen = probe.seen ? 1.0 : 0.0;
    hash.mix(&seen, 1);
    hash.mix(probe.tissue_T_probe.rotation.data(), 9);
    hash.mix(probe.tissue_T_probe.translation.data(), 3);
  }
  return hash.value();
}

}  // namespace tissued::core
