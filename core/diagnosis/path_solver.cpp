#include "core/diagnosis/path_solver.hpp"

#include <algorithm>

#include "core/diagnosis/motion_solver.hpp"

namespace tissued::core {

namespace {

// Far below noise; derivatives are taken at the same state, whatever is left of its residual.
constexpr FemControl kControl{1e-4, 30, 6.0, 1e-3};

FemOptions options_of(const std::vector<const Effect*>& effects, FemElement element) {
  FemOptions options;
  options.element = element;
  for (const Effect* effect : effects)
    options.effects.push_back([effect](const Scene& scene, const FemMesh& mesh, FemPhysics& physics) {
      effect->add_to(scene, mesh, physics);
    });
  return options;
}

}  // namespace

PathSolver::PathSolver(const Scene& scene, std::vector<const Effect*> effects, FemElement element)
    : model_(scene, options_of(effects, element)),
      equilibrium_(model_, 1),
      has_history_(std::any_of(effects.begin(), effects.end(), [](const Effect* e) { return e->has_history(); })),
      channels_(channels_of(scene)),
      rest_(model_.rest()) {}

Eigen::RowVectorXd PathSolver::observe(const FemState& state, std::span<const PadInput> pads) const {
  Eigen::RowVectorXd seen(channels_.count());
  for (int i = 0; i < channels_.markers; ++i) {
    const FemPoint& point = model_.marker_points()[i];
    seen.segment<3>(channels_.of_marker(i)) = position_of(point, state.x) - position_of(point, rest_);
  }
  for (int i = 0; i < channels_.targets; ++i) {
    const FemPoint& point = model_.target_points()[i];
    seen.segment<3>(channels_.of_target(i)) = position_of(point, state.x) - position_of(point, rest_);
  }
  const std::vector<Vec3> forces = pad_forces(state, pads);
  for (int i = 0; i < channels_.pads; ++i) seen.segment<3>(channels_.of_force(i)) = forces[i];
  return seen;
}

FemReport PathSolver::find(const LoadKey& key, double time_step, FemState& state) {
  FemControl control = kControl;
  control.most_corrections = most_corrections_ - corrections_;
  const FemReport report = solve_static(equilibrium_, state, {key.pads, nullptr}, control, time_step);
  corrections_ += report.corrections;
  return report;
}

bool PathSolver::solve_key(const LoadKey& key, double time_step, const Eigen::VectorXd* start, FemState& state) {
  const FemState before = state;
  if (start != nullptr) state.x = *start;
  FemReport report = find(key, time_step, state);
  if (!report.converged && start != nullptr && corrections_ < most_corrections_) {
    state = before;
    equilibrium_.forget_factor();
    report = find(key, time_step, state);
  }
  if (!report.converged) trouble_ = report.words();
  return report.converged;
}

void PathSolver::differentiate(const LoadKey& key, double time_step, const FemHistory& before, const FemState& state,
                               std::span<const PathParameter> parameters, std::vector<FemHistory>& perturbed,
                               std::vector<Eigen::RowVectorXd>& derivatives) {
  derivatives.assign(parameters.size(), Eigen::RowVectorXd::Zero(channels_.count()));
  FemBalance balance;
  balance.time_step = time_step;
  if (!equilibrium_.factor_at(balance, state.x, before, state.hold)) return;
  Eigen::VectorXd residual;
  equilibrium_.terms(state.x, time_step, before, residual);
  FemState at = state;
  at.force = at.reaction = residual;
  at.pressed = equilibrium_.pressed(at.x, time_step, before);
  const Eigen::RowVectorXd seen = observe(at, key.pads);
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    shift(parameters[j]);
    Eigen::VectorXd shifted;
    equilibrium_.terms(state.x, time_step, perturbed[j], shifted);
    at.x = state.x + equilibrium_.factor().solve(residual - shifted);
    equilibrium_.terms(at.x, time_step, perturbed[j], at.force);
    at.reaction = at.force;
    at.pressed = equilibrium_.pressed(at.x, time_step, perturbed[j]);
    derivatives[j] = (observe(at, key.pads) - seen) / parameters[j].step;
    equilibrium_.accept(at.x, time_step, perturbed[j]);
    unshift(parameters[j]);
  }
}

void PathSolver::shift(const PathParameter& parameter) {
  for (const auto& [name, other] : parameter.with) model_.set_parameter(name, other);
  model_.set_parameter(parameter.name, values_.at(parameter.name) + parameter.step);
}

void PathSolver::unshift(const PathParameter& parameter) {
  model_.set_parameter(parameter.name, values_.at(parameter.name));
  for (const auto& other : parameter.with) model_.set_parameter(other.first, values_.at(other.first));
}

double PathSolver::value(const std::string& name) const {
  const auto found = values_.find(name);
  return found == values_.end() ? 0.0 : found->second;
}

bool PathSolver::solve(const LoadPath& path, int slot, std::span<const PathParameter> parameters, PathAnswer& answer) {
  if (path.motion() != nullptr) return solve_motion(*this, path, parameters, answer, trouble_);
  corrections_ = 0;
  const auto keys = path.keys().size();
  if (positions_.size() <= static_cast<std::size_t>(slot)) positions_.resize(static_cast<std::size_t>(slot) + 1);
  std::vector<Eigen::VectorXd>& positions = positions_[static_cast<std::size_t>(slot)];
  const bool is_warm = positions.size() == keys;
  if (!is_warm) positions.assign(keys, rest_);
  answer.values.setZero(static_cast<Eigen::Index>(keys), channels_.count());
  answer.by_parameter.assign(parameters.size(), answer.values);

  FemState state = rest_state(model_);
  equilibrium_.forget_factor();
  std::vector<FemHistory> perturbed(parameters.size(), state.history);
  std::vector<Eigen::RowVectorXd> derivatives;
  std::vector<int> key_of_pose(static_cast<std::size_t>(path.pose_count()), -1);
  double time = path.keys().front().time;
  for (std::size_t k = 0; k < keys; ++k) {
    const LoadKey& key = path.keys()[k];
    const auto row = static_cast<Eigen::Index>(k);
    if (const int known = key_of_pose[key.pose]; !has_history_ && known >= 0) {
      answer.values.row(row) = answer.values.row(known);
      for (RowMatrix& by : answer.by_parameter) by.row(row) = by.row(known);
      positions[k] = positions[known];
      state.x = positions[k];
      continue;
    }
    key_of_pose[key.pose] = static_cast<int>(k);
    const double time_step = has_history_ ? key.time - time : 0.0;
    time = key.time;
    const FemHistory before = parameters.empty() ? FemHistory{} : state.history;
    if (!solve_key(key, time_step, is_warm ? &positions[k] : nullptr, state)) return false;
    positions[k] = state.x;
    answer.values.row(row) = observe(state, key.pads);
    if (parameters.empty()) continue;
    differentiate(key, time_step, before, state, parameters, perturbed, derivatives);
    for (std::size_t j = 0; j < parameters.size(); ++j) answer.by_parameter[j].row(row) = derivatives[j];
  }
  return true;
}

}  // namespace tissued::core
