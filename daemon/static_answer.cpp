#include "daemon/static_answer.hpp"

#include <cmath>
#include <cstdio>

#include "core/fem_dynamics.hpp"

namespace tissued::daemon {
namespace {

std::array<double, 3> columns(const core::Vec3& v) { return {v.x(), v.y(), v.z()}; }

template <typename... Numbers>
std::string format(const char* text, Numbers... numbers) {
  char line[200];
  std::snprintf(line, sizeof line, text, numbers...);
  return line;
}

// The displacement of the nodes, interpolated at a material point.
core::Vec3 displacement_at(const StaticAnswer& answer, const core::MaterialPoint& point) {
  core::Vec3 moved = core::Vec3::Zero();
  for (std::size_t a = 0; a < 4; ++a)
    moved += point.weights[a] * core::Vec3(answer.displacement[point.nodes[a]].data());
  return moved;
}

// The pads at a share of their way.
std::vector<core::PadInput> on_the_way(const core::Scene& scene, std::span<const core::PadInput> pads, double share) {
  std::vector<core::PadInput> out(pads.begin(), pads.end());
  for (std::size_t p = 0; p < out.size(); ++p)
    out[p].center = scene.pads[p].center + share * (pads[p].center - scene.pads[p].center);
  return out;
}

core::FemReport travel(core::FemEquilibrium& equilibrium, core::FemState& state, std::span<const core::PadInput> pads,
                       const FemRun& run, const core::FemControl& control) {
  core::FemDynamics dynamics(equilibrium, core::TimeScheme{}, core::RayleighDamping{});
  const int steps = std::max(1, static_cast<int>(std::lround(run.duration / run.time_step)));
  core::FemReport total;
  for (int n = 1; n <= steps; ++n) {
    const auto there = on_the_way(equilibrium.model().scene(), pads, static_cast<double>(n) / steps);
    core::FemReport step = dynamics.step(state, {there, nullptr}, run.duration / steps, control);
    step.load_steps += total.load_steps;
    step.corrections += total.corrections;
    step.factorizations += total.factorizations;
    step.load = (n - 1 + step.load) / steps;
    total = step;
    if (!step.converged) break;
  }
  return total;
}

// There in no time, then held: in steps that grow, as what relaxes gets slower.
core::FemReport push_and_hold(core::FemEquilibrium& equilibrium, core::FemState& state,
                              std::span<const core::PadInput> pads, const FemRun& run,
                              const core::FemControl& control) {
  core::FemReport report = core::solve_static(equilibrium, state, {pads, nullptr}, control);
  constexpr int kSteps = 12;
  const auto time = [&run](int step) { return run.hold * std::pow(static_cast<double>(step) / kSteps, 3.0); };
  for (int n = 1; n <= kSteps && run.hold > 0.0 && report.converged; ++n) {
    core::FemReport step = core::solve_static(equilibrium, state, {pads, nullptr}, control, time(n) - time(n - 1));
    step.load_steps += report.load_steps;
    step.corrections += report.corrections;
    step.factorizations += report.factorizations;
    report = step;
  }
  return report;
}

}  // namespace

StaticAnswer answer_of_admm(const core::Scene& scene, std::span<const core::PadInput> pads,
                            const core::StaticOptions& options,
                            const std::function<void(const core::StaticIteration&)>& watch) {
  const core::StaticSolution solution = core::solve_static(scene, pads, options, watch);
  StaticAnswer answer;
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    answer.rest.push_back(columns(scene.mesh.node(i)));
    answer.displacement.push_back(columns(solution.positions.row(i).head<3>().transpose() - scene.mesh.node(i)));
  }
  answer.pad_forces = solution.pad_forces;
  const auto read = [&](const core::Vec3& rest) {
    return displacement_at(answer, core::locate_in_volume(scene.mesh, rest));
  };
  for (const auto& marker : scene.markers) answer.markers.push_back(read(marker.rest));
  for (const auto& target : scene.targets) answer.targets.push_back(read(target.rest));
  answer.converged = solution.converged;
  answer.summary = format("%d iterations: residual %.2e mm, largest unbalanced force %.2e N", solution.iterations,
                          solution.residual, solution.force_residual);
  answer.trouble = solution.trouble;
  answer.figures = {{"iterations", solution.iterations},
                    {"residual_mm", solution.residual},
                    {"force_residual_N", solution.force_residual},
                    {"inverted", solution.inverted}};
  return answer;
}

StaticAnswer answer_of_fem(const core::Scene& scene, std::span<const core::PadInput> pads, const FemRun& run) {
  core::FemOptions options;
  options.element = run.element;
  for (const core::EffectSetting& chosen : run.effects) options.effects.push_back(core::fem_effect(*chosen.effect));
  core::FemModel model(scene, options);
  for (const core::EffectSetting& chosen : run.effects) core::set_effect(model, *chosen.effect, chosen.values);
  core::FemEquilibrium equilibrium(model, run.threads);
  core::FemState state = core::rest_state(model);
  core::FemControl control;
  control.tolerance = run.tolerance;
  const core::FemReport report = run.duration > 0.0 ? travel(equilibrium, state, pads, run, control)
                                                    : push_and_hold(equilibrium, state, pads, run, control);
  StaticAnswer answer;
  const Eigen::VectorXd rest = model.rest(), moved = state.x - rest;
  for (int i = 0; i < model.mesh().node_count(); ++i) {
    answer.rest.push_back(columns(rest.segment<3>(3 * i)));
    answer.displacement.push_back(columns(moved.segment<3>(3 * i)));
  }
  answer.pad_forces = core::pad_forces(state, pads);
  for (const core::FemPoint& point : model.marker_points()) answer.markers.push_back(core::position_of(point, moved));
  for (const core::FemPoint& point : model.target_points()) answer.targets.push_back(core::position_of(point, moved));
  answer.converged = report.converged;
  answer.summary = format(
      "%d load steps, %d corrections, %d factorisations: last correction %.2e mm, largest unbalanced "
      "force %.2e N",
      report.load_steps, report.corrections, report.factorizations, report.correction, report.force_residual);
  answer.trouble = report.words();
  answer.figures = {{"load", report.load},
                    {"load_steps", report.load_steps},
                    {"iterations", report.corrections},
                    {"factorizations", report.factorizations},
                    {"residual_mm", report.correction},
                    {"force_residual_N", report.force_residual}};
  return answer;
}

}  // namespace tissued::daemon
