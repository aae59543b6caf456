// Error against time per iteration: elements that ADMM can carry, statically, against quadratic finite elements on the
// same mesh.
#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/bundle.hpp"
#include "core/admm.hpp"
#include "core/fem_solver.hpp"
#include "core/static_solve.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/benchmark/stopwatch.hpp"

namespace {

using namespace tissued;
using benchmark::milliseconds, benchmark::times_of;

struct Push {
  std::vector<std::size_t> pads;
  double depth;  // mm
};

// What is seen of an equilibrium.
struct Answer {
  std::vector<core::Vec3> markers, targets;  // mm, displacements
  double force = 0.0;                        // N, of all pads, sizes added
  bool converged = false;
};

std::vector<core::PadInput> pads_of(const core::Scene& scene, const Push& push) {
  std::vector<core::PadInput> inputs(scene.pads.size());
  for (const std::size_t pad : push.pads) {
    inputs[pad].kind = core::PadInput::Kind::pose;
    inputs[pad].center = scene.pads[pad].center + push.depth * scene.pads[pad].direction;
  }
  return inputs;
}

void add_forces(const std::vector<core::Vec3>& forces, const Push& push, Answer& answer) {
  for (const std::size_t pad : push.pads) answer.force += forces[pad].norm();
}

// ms_per_correction: of the whole way there.
Answer quadratic(const core::Scene& scene, const Push& push, double& ms_per_correction) {
  const core::FemModel model(scene, core::FemOptions{});
  core::FemEquilibrium equilibrium(model, 1);
  core::FemState state = core::rest_state(model);
  const auto pads = pads_of(scene, push);
  core::FemReport report;
  core::FemControl control;
  control.largest_move = 3.0;  // mm; deep pushes at once take it past its own bifurcations
  const double ms = milliseconds([&] { report = core::solve_static(equilibrium, state, {pads}, control); });
  ms_per_correction = ms / std::max(report.corrections, 1);
  Answer answer;
  answer.converged = report.converged;
  if (!report.converged) std::printf("the judge gave up: %s\n", report.words().c_str());
  const Eigen::VectorXd rest = model.rest();
  const auto moved = [&](const core::FemPoint& point) {
    return core::Vec3(core::position_of(point, state.x) - core::position_of(point, rest));
  };
  for (const auto& point : model.marker_points()) answer.markers.push_back(moved(point));
  for (const auto& point : model.target_points()) answer.targets.push_back(moved(point));
  add_forces(core::pad_forces(state, pads), push, answer);
  return answer;
}

Answer by_admm(const core::Scene& scene, const core::Model& model, const Push& push) {
  core::StaticOptions options;
  options.element = model.element();
  options.tolerance = 1e-4;
  options.threads = 1;
  const core::StaticSolution solution = core::solve_static(scene, pads_of(scene, push), options);
  Answer answer;
  answer.converged = solution.converged;
  const auto moved = [&](const core::MaterialPoint& point) {
    return core::Vec3(core::position_of(point, solution.positions) - core::position_of(point, model.rest()));
  };
  for (const auto& point : model.marker_points()) answer.markers.push_back(moved(point));
  for (const auto& point : model.target_points()) answer.targets.push_back(moved(point));
  add_forces(solution.pad_forces, push, answer);
  return answer;
}

// ms, one thread, in the midst of a push.
double iteration_ms(const core::Model& model, const Push& push) {
  core::AdmmState state(model);
  core::AdmmWorkspace workspace(model, 1);
  core::begin_step(model, state, workspace, pads_of(model.scene(), push), model.time_step(), push.depth);
  const auto iterate = [&] {
    core::local_stage(model, state, workspace);
    core::global_stage(model, state, workspace, model.time_step());
  };
  for (int warm = 0; warm < 50; ++warm) iterate();
  return times_of(300, iterate).p50;
}

double rms(const std::vector<core::Vec3>& a, const std::vector<core::Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double mean(const std::vector<core::Vec3>& a, const std::vector<core::Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).norm();
  return sum / static_cast<double>(a.size());
}

struct Named {
  core::Element element;
  const char* name;
};

constexpr std::array kElements{Named{core::Element::p1, "P1: element, element"},
                               Named{core::Element::edge, "edge, edge"}, Named{core::Element::node, "node, node"},
                               Named{core::Element::edge_node, "edge, node"},
                               Named{core::Element::smoothed, "smoothed: 0.9 edge 0.1 node, node"}};

void compare(core::Scene scene, double poissons_ratio, const std::vector<Push>& pushes) {
  scene.material.poissons_ratio = poissons_ratio;
  std::vector<Answer> judge;
  double correction_ms = 0.0;
  for (const Push& push : pushes) judge.push_back(quadratic(scene, push, correction_ms));
  std::printf("\nnu %.2f %37s", poissons_ratio, "ms an iteration");
  for (const Push& push : pushes) {
    std::string name;
    for (const std::size_t pad : push.pads) name += (name.empty() ? "" : "+") + scene.pads[pad].name;
    std::printf("   | %5s %2.0f mm: markers, targets, force", name.c_str(), push.depth);
  }
  std::printf("\n");
  for (const Named& named : kElements) {
    const core::Model model(scene, named.element, core::StaticOptions{}.weight_scale, 0.01);
    std::printf("%-36s %8.3f", named.name, iteration_ms(model, pushes.front()));
    for (std::size_t k = 0; k < pushes.size(); ++k) {
      const Answer answer = by_admm(scene, model, pushes[k]);
      std::printf("   |   %12.3f %10.3f %8.3f%s", rms(answer.markers, judge[k].markers),
                  mean(answer.targets, judge[k].targets), answer.force / judge[k].force,
                  answer.converged ? "  " : " *");
      std::fflush(stdout);
    }
    std::printf("\n");
  }
  std::printf("%-36s %8.1f   (a Newton correction)\n", "P2, fem: the judge", correction_ms);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: element_benchmark BUNDLE\n");
    return 2;
  }
  try {
    const core::Scene scene = daemon::load_scene(config::load_bundle(argv[1]));
    if (scene.pads.empty()) throw std::runtime_error(std::string(argv[1]) + ": no pads to push with");
    std::vector<Push> pushes{{{0}, 10.0}};
    if (scene.pads.size() > 2) pushes.push_back({{0, 2}, 12.0});  // by 14 mm the softest of the judges buckles
    std::printf(
        "%s, %d tetrahedra; gradients averaged over: shape, volume. Errors in mm (markers RMS, targets mean), "
        "pad force as a ratio; * not converged\n",
        scene.name.c_str(), scene.mesh.tet_count());
    for (const double poissons_ratio : {0.35, 0.45, 0.49}) compare(scene, poissons_ratio, pushes);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "element_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
