#include "core/fem_solver.hpp"

namespace tissued::core {

FemState rest_state(const FemModel& model) {
  FemState state;
  state.x = model.rest();
  state.velocity.setZero(state.x.size());
  state.acceleration.setZero(state.x.size());
  state.force.setZero(state.x.size());
  state.reaction = state.force;
  for (const auto& term : model.terms()) state.history.emplace_back(term->history_size(), 0.0);
  state.hold = hold_of(model, {});
  state.pressed.assign(model.scene().pads.size(), Vec3::Zero());
  return state;
}

FemHold hold_of(const FemModel& model, std::span<const PadInput> pads) {
  FemHold hold{model.fixed(), model.rest(), std::vector<int>(model.fixed().size(), -1), {pads.begin(), pads.end()}};
  if (!model.pads_hold()) return hold;
  for (std::size_t p = 0; p < pads.size(); ++p) {
    if (pads[p].kind != PadInput::Kind::pose) continue;
    for (int node : model.pad_nodes()[p]) {
      if (hold.held[node]) continue;
      hold.held[node] = 1;
      hold.pad[node] = static_cast<int>(p);
      const Vec3 arm = model.mesh().rest.row(node).transpose() - model.scene().pads[p].center;
      hold.position.segment<3>(3 * node) = pads[p].center + pads[p].rotation * arm;
    }
  }
  return hold;
}

Eigen::VectorXd external_forces(const FemModel& model, const FemLoads& loads) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * model.mesh().node_count());
  if (loads.external != nullptr) force = *loads.external;
  for (std::size_t p = 0; p < loads.pads.size(); ++p) {
    if (loads.pads[p].kind != PadInput::Kind::force) continue;
    for (std::size_t k = 0; k < model.pad_nodes()[p].size(); ++k)
      force.segment<3>(3 * model.pad_nodes()[p][k]) +=
          kMillinewtonPerNewton * model.pad_shares()[p][k] * loads.pads[p].force;
  }
  return force;
}

FemReport solve_static(FemEquilibrium& equilibrium, FemState& state, const FemLoads& loads, const FemControl& control,
                       double time_step) {
  const FemModel& model = equilibrium.model();
  const Eigen::VectorXd external = external_forces(model, loads);
  FemBalance balance;
  balance.time_step = time_step;
  balance.offset = -external;
  state.hold = hold_of(model, loads.pads);
  const FemReport report = equilibrium.find(balance, state.hold, state.history, control, state.x);
  equilibrium.terms(state.x, time_step, state.history, state.force);
  state.force -= external;
  state.reaction = state.force;
  state.pressed = equilibrium.pressed(state.x, time_step, state.history);
  state.velocity.setZero();
  state.acceleration.setZero();
  if (report.converged) equilibrium.accept(state.x, time_step, state.history);
  return report;
}

std::vector<Vec3> pad_forces(const FemState& state, std::span<const PadInput> pads) {
  std::vector<Vec3> forces(pads.size(), Vec3::Zero());
  for (std::size_t p = 0; p < pads.size(); ++p) {
    if (pads[p].kind == PadInput::Kind::force) forces[p] = pads[p].force;
    if (pads[p].kind == PadInput::Kind::pose) forces[p] = state.pressed[p];
  }
  for (std::size_t i = 0; i < state.hold.pad.size(); ++i)
    if (state.hold.pad[i] >= 0)
      forces[state.hold.pad[i]] += state.reaction.segment<3>(3 * static_cast<Eigen::Index>(i)) / kMillinewtonPerNewton;
  return forces;
}

}  // namespace tissued::core
