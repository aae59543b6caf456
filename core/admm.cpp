#include "core/admm.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>

namespace tissued::core {

AdmmState::AdmmState(const Model& model) : domains(static_cast<std::size_t>(model.blocks().count())) { reset(model); }

void AdmmState::reset(const Model& model) {
  x = model.rest();
  x_previous = model.rest();
  dt = model.time_step();
  reset_domain_states(domains);
}

AdmmWorkspace::AdmmWorkspace(const Model& model, int thread_count)
    : x_tilde(model.rest()),
      external(NodeField::Zero(model.rest().rows(), 4)),
      forces(model.blocks().corners.size()),
      delta(static_cast<std::size_t>(4 * model.system().free_count())),
      held(model.holdable()),
      held_groups(static_cast<std::size_t>(model.holdable().group_count())),
      rotations(held_groups.size(), Mat3::Identity()),
      prescribed(static_cast<std::size_t>(model.holdable().count()), Eigen::Vector4d::Zero()),
      wanted(static_cast<std::size_t>(model.holdable().count()), Eigen::Vector4d::Zero()),
      contact(model.contact_surface(), model.scene().probes, model.holdable().count()),
      contact_change(model.scene().probes.empty() ? 0 : delta.size()),
      threads(thread_count),
      pads_(model.scene().pads.size()) {
  release_pads();
}

void AdmmWorkspace::release_pads() {
  for (std::size_t group = 0; group < held_groups.size(); ++group) held_groups[group] = group < pads_ ? 0 : 1;
  std::fill(rotations.begin(), rotations.end(), Mat3::Identity());
  held.hold(held_groups, rotations);
  held.forget_forces();
}

int resolve_threads(int requested, int tets) {
  constexpr int kWorthSharing =
      8000;  // tetrahedra; below, waking a second thread costs what it saves (benchmark `step`)
  if (requested > 0) return requested;
  return tets < kWorthSharing ? 1 : std::max(1, omp_get_num_procs());
}

namespace {

// Where a node of a rigid pad is.
Eigen::Vector4d on_pad(const Pad& pad, const PadInput& input, const Eigen::Vector4d& rest) {
  Eigen::Vector4d position = Eigen::Vector4d::Zero();
  position.head<3>() = input.center + input.rotation * (rest.head<3>() - pad.center);
  return position;
}

void hold_pads(const Model& model, AdmmWorkspace& workspace, std::span<const PadInput> pads) {
  constexpr double kTurned = 1e-9;  // of an entry of the rotation
  bool changed = false;
  for (std::size_t p = 0; p < pads.size(); ++p) {
    const std::uint8_t holds = pads[p].kind == PadInput::Kind::pose;
    changed |= workspace.held_groups[p] != holds;
    workspace.held_groups[p] = holds;
    if (!holds || !model.holdable().slides()) continue;
    changed |= (workspace.rotations[p] - pads[p].rotation).cwiseAbs().maxCoeff() > kTurned;
    workspace.rotations[p] = pads[p].rotation;
  }
  if (changed) workspace.held.hold(workspace.held_groups, workspace.rotations);
}

void gather_external(const Model& model, AdmmWorkspace& workspace, std::span<const PadInput> pads) {
  const Eigen::Vector4d acceleration = model.acceleration();
  for (Eigen::Index i = 0; i < workspace.external.rows(); ++i)
    workspace.external.row(i) = model.body_masses()[i] * acceleration.transpose();
  for (std::size_t p = 0; p < pads.size(); ++p) {
    if (pads[p].kind != PadInput::Kind::force) continue;
    for (std::size_t k = 0; k < model.pad_nodes()[p].size(); ++k) {
      workspace.external.row(model.pad_nodes()[p][k]).head<3>() +=
          model.pad_shares()[p][k] * kMillinewtonPerNewton * pads[p].force.transpose();
    }
  }
}

}  // namespace

double begin_step(const Model& model, const AdmmState& state, AdmmWorkspace& workspace, std::span<const PadInput> pads,
                  double dt, double pad_limit) {
  hold_pads(model, workspace, pads);
  gather_external(model, workspace, pads);
  // (2) without its force term, which the residual carries as it is: M (x_tilde - x) / dt^2 = ... + F_ext.
  const double extrapolate = std::isinf(dt) ? 0.0 : dt / state.dt;
  workspace.x_tilde = state.x + extrapolate * (state.x - state.x_previous);
  double cut = 0.0;
  for (int k = 0; k < workspace.held.count(); ++k) {
    const int node = workspace.held.node(k);
    const auto pad = static_cast<std::size_t>(workspace.held.group(k));
    const Eigen::Vector4d from = state.x.row(node).transpose(), rest = model.rest().row(node).transpose();
    const Eigen::Vector4d to = pad < pads.size() ? on_pad(model.scene().pads[pad], pads[pad], rest) : rest;
    Eigen::Vector4d move = workspace.held.level(k, from, to) - from;
    const double length = move.norm();
    if (length > pad_limit) {
      cut = std::max(cut, length - pad_limit);
      move *= pad_limit / length;
    }
    workspace.prescribed[k] = from + move;
    const Eigen::Vector4d tilde = workspace.x_tilde.row(node).transpose();
    workspace.x_tilde.row(node) = workspace.held.level(k, tilde, workspace.prescribed[k]).transpose();  // (20)
  }
  return cut;
}

double begin_contact(const AdmmState& state, AdmmWorkspace& workspace, std::span<const ProbeInput> probes,
                     double limit) {
  return probes.empty() ? 0.0 : workspace.contact.begin(probes, state.x, workspace.held, limit);
}

LocalStepResult local_stage(const Model& model, AdmmState& state, AdmmWorkspace& workspace,
                            PointDeformation* deformations) {
  const int blocks = model.blocks().count();
  const auto run = [&](int first, int last) {
    return local_step(model.blocks(), first, last, state.x.data(), state.domains.data(), workspace.forces.data(),
                      deformations);
  };
  if (workspace.threads == 1) return run(0, blocks);
  LocalStepResult total;
#pragma omp parallel num_threads(workspace.threads)
  {
    const int count = omp_get_num_threads(), id = omp_get_thread_num();
    const LocalStepResult part = run(blocks * id / count, blocks * (id + 1) / count);
#pragma omp critical
    {
      total.primal = std::max(total.primal, part.primal);
      total.inverted += part.inverted;
      total.unconverged += part.unconverged;
    }
  }
  return total;
}

namespace {

// r = M (x_tilde - x) / dt^2 + f_ext - D^T W^2 (Dx - z + u), rounded to the factor's precision, rows in its order.
void residual_rows(const Model& model, const AdmmState& state, AdmmWorkspace& workspace, double dt,
                   const NodeField* node_forces, int first, int last) {
  const double* forces = reinterpret_cast<const double*>(workspace.forces.data());
  const double per_dt2 = 1.0 / (dt * dt);
  for (int row = first; row < last; ++row) {
    const int node = model.system().node_of_row(row);
    double sum[3] = {0.0, 0.0, 0.0};
    for (const std::int64_t offset : model.system().incident(row)) {
      sum[0] += forces[offset];
      sum[1] += forces[offset + kLanes];
      sum[2] += forces[offset + 2 * kLanes];
    }
    if (node_forces != nullptr)
      for (int axis = 0; axis < 3; ++axis) sum[axis] += (*node_forces)(node, axis);
    const double inertia = model.masses()[node] * per_dt2, drag = model.masses()[node] * model.mass_damping() / dt;
    for (int axis = 0; axis < 3; ++axis) {
      const double r = sum[axis] + workspace.external(node, axis) +
                       inertia * (workspace.x_tilde(node, axis) - state.x(node, axis)) +
                       drag * (state.x_previous(node, axis) - state.x(node, axis));
      workspace.delta[4 * static_cast<std::size_t>(row) + axis] = static_cast<float>(r);
    }
    workspace.delta[4 * static_cast<std::size_t>(row) + 3] = 0.0f;
  }
}

// Changes delta by what contact forces that answer it do; false where none changes. The hold is to be enforced again.
bool answer_contact(const Model& model, const NodeField& x, AdmmWorkspace& workspace) {
  if (workspace.contact.empty()) return false;
  if (!workspace.contact.solve(x, workspace.delta.data(), workspace.contact_change)) return false;
  model.system().factor().panels().solve(workspace.contact_change.data());
  for (std::size_t i = 0; i < workspace.delta.size(); ++i) workspace.delta[i] += workspace.contact_change[i];
  return true;
}

}  // namespace

double global_stage(const Model& model, AdmmState& state, AdmmWorkspace& workspace, double dt,
                    const NodeField* node_forces) {
  const int free = model.system().free_count();
  if (workspace.threads == 1) {
    residual_rows(model, state, workspace, dt, node_forces, 0, free);
  } else {
#pragma omp parallel num_threads(workspace.threads)
    {
      const int count = omp_get_num_threads(), id = omp_get_thread_num();
      residual_rows(model, state, workspace, dt, node_forces,
                    static_cast<int>(static_cast<std::int64_t>(free) * id / count),
                    static_cast<int>(static_cast<std::int64_t>(free) * (id + 1) / count));
    }
  }
  HeldNodes& held = workspace.held;
  held.add_forces(workspace.delta.data());
  workspace.contact.add_forces(workspace.delta.data());
  model.system().factor().panels().solve(workspace.delta.data());
  for (int k = 0; k < held.count(); ++k)
    workspace.wanted[k] = workspace.prescribed[k] - state.x.row(held.node(k)).transpose();
  held.enforce(workspace.delta.data(), workspace.wanted);
  if (answer_contact(model, state.x, workspace)) held.enforce(workspace.delta.data(), workspace.wanted);
  float largest = 0.0f;
  for (int row = 0; row < free; ++row) {
    const Eigen::Map<const Eigen::Vector4f> move(workspace.delta.data() + 4 * static_cast<std::ptrdiff_t>(row));
    state.x.row(model.system().node_of_row(row)) += move.cast<double>().transpose();
    largest = std::max(largest, move.squaredNorm());
  }
  for (int k = 0; k < held.count(); ++k) {
    const Eigen::Vector4d at = state.x.row(held.node(k)).transpose();
    state.x.row(held.node(k)) = held.level(k, at, workspace.prescribed[k]).transpose();
  }
  return std::sqrt(static_cast<double>(largest));
}

void restore_contact(const Model& model, AdmmState& state, AdmmWorkspace& workspace) {
  std::fill(workspace.delta.begin(), workspace.delta.end(), 0.0f);
  if (!answer_contact(model, state.x, workspace)) return;
  for (int k = 0; k < workspace.held.count(); ++k) workspace.wanted[k].setZero();
  workspace.held.enforce(workspace.delta.data(), workspace.wanted);
  for (int row = 0; row < model.system().free_count(); ++row) {
    const Eigen::Map<const Eigen::Vector4f> move(workspace.delta.data() + 4 * static_cast<std::ptrdiff_t>(row));
    state.x.row(model.system().node_of_row(row)) += move.cast<double>().transpose();
    state.x_previous.row(model.system().node_of_row(row)) += move.cast<double>().transpose();
  }
}

void pad_forces(const AdmmWorkspace& workspace, std::span<Vec3> out) {
  for (Vec3& f : out) f.setZero();
  for (int k = 0; k < workspace.held.count(); ++k)
    if (static_cast<std::size_t>(workspace.held.group(k)) < out.size())
      out[workspace.held.group(k)] += workspace.held.force(k).head<3>() / kMillinewtonPerNewton;
}

}  // namespace tissued::core
