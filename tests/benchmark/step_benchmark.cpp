// Times the simulators' steps: the paper's own loads, ms per iteration by size of the mesh and by threads, and, beside
// them in the same run, one CHOLMOD solve of the same global matrix as the reference of the machine.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <vector>

#include "config/bundle.hpp"
#include "core/admm.hpp"
#include "core/model.hpp"
#include "core/simulator.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/benchmark/block_body.hpp"
#include "tests/benchmark/stopwatch.hpp"

namespace {

using namespace tissued;
using benchmark::Times, benchmark::times_of;

core::Observation pushed(const core::Scene& scene, double depth) {
  core::Observation observation;
  observation.resize_for(scene);
  observation.dt = 0.01;
  observation.pads[0].kind = core::PadInput::Kind::pose;
  observation.pads[0].center = scene.pads[0].center + depth * scene.pads[0].direction;
  for (std::size_t m = 0; m < scene.markers.size(); ++m) {
    observation.markers[m] = scene.markers[m].rest + 0.1 * depth * scene.pads[0].direction;
    observation.marker_seen[m] = 1;
  }
  return observation;
}

// One load of the paper: so many iterations at 20 mm, as frames of `per_frame` iterations, gains settled.
void paper_load(const core::Scene& scene, const char* kind, core::Scheme scheme, int iterations, int per_frame,
                double limit_ms, double paper_s) {
  core::SimulatorOptions options;
  options.kind = kind;
  options.filter.preset = core::NoisePreset::paper;
  options.solver.element = core::Element::p1;
  options.solver.weight_scale = 4.0;
  options.solver.tolerance = 0.0;  // all iterations, however little is left to do
  options.solver.scheme = scheme;
  options.solver.iterations = per_frame;
  options.solver.threads = 1;
  const auto simulator = core::make_simulator(scene, options);
  for (int warm = 1; warm <= 200; ++warm) simulator->step(pushed(scene, std::min(20.0, 0.2 * warm)));
  const core::Observation observation = pushed(scene, 20.0);
  const Times t = times_of(60, [&] {
    for (int done = 0; done < iterations; done += per_frame) simulator->step(observation);
  });
  std::printf(
      "%-8s %3d iterations, 20 mm     p50 %7.2f  p99 %7.2f  max %7.2f ms   (goal %.0f ms; paper %.2f s: %.0f x)\n",
      kind, iterations, t.p50, t.p99, t.max, limit_ms, paper_s, 1e3 * paper_s / t.p50);
}

void by_size(const core::Scene& scene, core::Element element, int threads, int repeats) {
  core::SolverOptions defaults;
  const core::Model model(scene, element, defaults.weight_scale, 0.01);
  core::AdmmState state(model);
  core::AdmmWorkspace workspace(model, threads);
  const core::Observation observation = pushed(scene, 3.0);
  core::begin_step(model, state, workspace, observation.pads, 0.01, 3.0);
  const auto iterate = [&] {
    core::local_stage(model, state, workspace);
    core::global_stage(model, state, workspace, 0.01);
  };
  for (int warm = 0; warm < 20; ++warm) iterate();
  const Times local = times_of(repeats, [&] { core::local_stage(model, state, workspace); });
  const Times whole = times_of(repeats, iterate);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Ones(model.system().free_count(), 3);
  const Times reference = times_of(repeats, [&] { model.system().factor().solve(right); });
  std::printf("%7d %7d %8s %8d  %8.3f %8.3f %8.3f   %8.3f   %8.3f   %5.2f\n", scene.mesh.tet_count(),
              scene.mesh.node_count(), element == core::Element::p1 ? "p1" : "smoothed", threads, whole.p50, whole.p99,
              whole.max, local.p50, reference.p50, whole.p50 / reference.p50);
}

}  // namespace

int main(int argc, char** argv) {
  std::optional<core::Scene> paper;
  if (argc > 1) paper = daemon::load_scene(config::load_bundle(argv[1]));
  const core::Scene& small = paper ? *paper : *(paper = benchmark::block_scene(2142));
  std::printf("The paper's loads on %s, %d tetrahedra, one thread\n", small.name.c_str(), small.mesh.tet_count());
  paper_load(small, "kf-admm", core::Scheme::algorithm_1, 200, 10, 60.0, 7.94);
  paper_load(small, "admm", core::Scheme::per_frame, 500, 500, 100.0, 10.58);
  std::printf(
      "\none iteration (local and global step), ms; solve: CHOLMOD with the same matrix, three right-hand sides\n");
  std::printf("   tets   nodes  element  threads       p50      p99      max      local      solve   ratio\n");
  for (core::Element element : {core::Element::p1, core::Element::smoothed}) {
    for (int threads : {1, 2}) by_size(small, element, threads, 1000);
    for (int threads : {1, 2}) by_size(benchmark::block_scene(20000), element, threads, 200);
    for (int threads : {1, 2}) by_size(benchmark::block_scene(100000), element, threads, 40);
  }
  return 0;
}
