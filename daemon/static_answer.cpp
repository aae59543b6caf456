#include "daemon/static_answer.hpp"

#include <cmath>
#include <cstdio>

#include "core/fem_dynamics.hpp"
#include "core/pbd_simulator.hpp"

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

double longest_way(const core::Scene& scene, std::span<const core::PadInput> pads) {
  double longest = 0.0;
  for (std::size_t p = 0; p < pads.size(); ++p)
    if (pads[p].kind != core::PadInput::Kind::absent)
      longest = std::max(longest, (pads[p].center - scene.pads[p].center).norm());
  return longest;
}

// How far time steps have come.
struct Settling {
  int iterations = 0, steps = 0;
  double move = 0.0;  // mm, the largest of a particle in the last time step
  bool settled = false;
};

Settling settle(core::PbdSimulator& simulator, std::span<const core::PadInput> pads, const PbdRun& run) {
  const core::Scene& scene = simulator.scene();
  const int travel = std::max(1, static_cast<int>(std::ceil(longest_way(scene, pads) / run.load_step)));
  core::Observation observation;
  observation.resize_for(scene);
  observation.dt = run.options.time_step;
  Settling progress;
  while (!progress.settled && progress.iterations < run.max_iterations) {
    const core::NodeField before = simulator.state().x;
    const double share = std::min(1.0, static_cast<double>(++progress.steps) / travel);
    observation.pads = on_the_way(scene, pads, share);
    const core::StepReport report = simulator.step(observation);
    progress.iterations += report.iterations;
    if (!report.finite) return progress;
    progress.move = (simulator.state().x - before).rowwise().norm().maxCoeff();
    progress.settled = progress.steps >= travel && progress.move <= run.tolerance;
  }
  return progress;
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

StaticAnswer answer_of_pbd(const core::Scene& scene, std::span<const core::PadInput> pads, const PbdRun& run) {
  core::SimulatorOptions options;
  options.kind = "pbd";
  options.pbd = run.options;
  core::PbdSimulator simulator(scene, options);
  const Settling progress = settle(simulator, pads, run);
  StaticAnswer answer;
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    answer.rest.push_back(columns(scene.mesh.node(i)));
    answer.displacement.push_back(columns(simulator.positions().row(i).head<3>().transpose() - scene.mesh.node(i)));
  }
  answer.pad_forces.assign(scene.pads.size(), core::Vec3::Zero());
  for (std::size_t i = 0; i < scene.markers.size(); ++i)
    answer.markers.push_back(simulator.marker(static_cast<int>(i)) - scene.markers[i].rest);
  for (std::size_t i = 0; i < scene.targets.size(); ++i)
    answer.targets.push_back(simulator.target(static_cast<int>(i)).position - scene.targets[i].rest);
  answer.converged = progress.settled;
  const int particles = simulator.model().lattice.count(), clusters = simulator.model().clusters.count();
  answer.summary = format("%d iterations in %d time steps of %d particles in %d clusters: last move %.2e mm",
                          progress.iterations, progress.steps, particles, clusters, progress.move);
  if (!progress.settled) answer.trouble = "particles still move";
  answer.figures = {{"iterations", progress.iterations},
                    {"time_steps", progress.steps},
                    {"particles", particles},
                    {"clusters", clusters},
                    {"residual_mm", progress.move}};
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
