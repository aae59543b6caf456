// Times the finite element solver on a body: its parts, a push in one go, and a ramp followed step by step.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <vector>

#include "config/bundle.hpp"
#include "core/fem_sensitivity.hpp"
#include "core/fem_solver.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/benchmark/block_body.hpp"
#include "tests/benchmark/stopwatch.hpp"

namespace {

using namespace tissued;
using benchmark::milliseconds, benchmark::times_of;

std::vector<core::PadInput> pushed(const core::Scene& scene, double depth) {
  std::vector<core::PadInput> pads(scene.pads.size());
  pads[0].kind = core::PadInput::Kind::pose;
  pads[0].center = scene.pads[0].center + depth * scene.pads[0].direction;
  return pads;
}

struct Ramp {
  double ms = 0.0;  // a step
  double corrections = 0.0, factorizations = 0.0;
  bool converged = true;
};

Ramp follow(core::FemEquilibrium& equilibrium, double depth, int steps) {
  core::FemState state = core::rest_state(equilibrium.model());
  Ramp ramp;
  ramp.ms = milliseconds([&] {
    for (int n = 1; n <= steps; ++n) {
      const auto pads = pushed(equilibrium.model().scene(), depth * n / steps);
      const core::FemReport report = core::solve_static(equilibrium, state, {pads}, core::FemControl{});
      ramp.converged = ramp.converged && report.converged;
      ramp.corrections += report.corrections;
      ramp.factorizations += report.factorizations;
    }
  });
  ramp.ms /= steps;
  ramp.corrections /= steps;
  ramp.factorizations /= steps;
  return ramp;
}

void print_ramp(const char* name, core::FemEquilibrium& equilibrium, double depth, int steps) {
  const Ramp ramp = follow(equilibrium, depth, steps);
  std::printf("  %-28s %8.1f ms a step, %5.1f solves, %4.2f factorisations a step%s\n", name, ramp.ms, ramp.corrections,
              ramp.factorizations, ramp.converged ? "" : "  NOT CONVERGED");
}

void measure(const core::Scene& scene, core::FemElement element, int threads) {
  core::FemOptions options;
  options.element = element;
  std::optional<core::FemModel> model;
  std::optional<core::FemEquilibrium> equilibrium;
  const double build = milliseconds([&] {
    model.emplace(scene, options);
    equilibrium.emplace(*model, threads);
  });
  core::FemState state = core::rest_state(*model);
  const auto pads = pushed(scene, 10.0);
  core::solve_static(*equilibrium, state, {pads}, core::FemControl{});
  Eigen::VectorXd residual;
  std::vector<double> values;
  const double forces = times_of(20, [&] { equilibrium->terms(state.x, 0.0, state.history, residual); }).p50;
  const double tangent = times_of(20, [&] { equilibrium->terms(state.x, 0.0, state.history, residual, &values); }).p50;
  const double factor = times_of(20, [&] { equilibrium->factor().factorize(values, state.hold.held); }).p50;
  const double solve = times_of(20, [&] { equilibrium->factor().solve(residual); }).p50;
  const double sensitivity = times_of(5, [&] {
                               const core::FemSensitivity all(*equilibrium, state);
                               for (int axis = 0; axis < 3; ++axis)
                                 all.adjoint(all.of_pad_force(0, core::Vec3::Unit(axis)));
                             }).p50;
  std::printf("%s, %d thread%s: %d rows, factor %.2f M entries, %.2f Gflop; set-up %.0f ms\n",
              element == core::FemElement::p1 ? "P1" : "P2", threads, threads > 1 ? "s" : "",
              equilibrium->factor().rows(), 1e-6 * equilibrium->factor().entries(),
              1e-9 * equilibrium->factor().flops(), build);
  std::printf(
      "  forces %.2f, forces and tangent %.2f, factorisation %.2f, solve %.2f, sensitivities of a pad force %.1f ms\n",
      forces, tangent, factor, solve, sensitivity);
  print_ramp("10 mm in one go", *equilibrium, 10.0, 1);
  print_ramp("10 mm in steps of 1 mm", *equilibrium, 10.0, 10);
  print_ramp("10 mm in steps of 0.1 mm", *equilibrium, 10.0, 100);
}

}  // namespace

int main(int argc, char** argv) {
  std::optional<core::Scene> scene;
  scene = argc > 1 ? daemon::load_scene(config::load_bundle(argv[1])) : benchmark::block_scene(2142);
  std::printf("%s, %d tetrahedra, E %g kPa, nu %g\n", scene->name.c_str(), scene->mesh.tet_count(),
              scene->material.youngs_modulus, scene->material.poissons_ratio);
  for (const core::FemElement element : {core::FemElement::p1, core::FemElement::p2})
    for (int threads : {1, 2}) measure(*scene, element, threads);
  return 0;
}
