// Probes on finite elements: against Hertz, and whether contact is what it should be.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/simulator.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

SimulatorOptions fem_options() {
  SimulatorOptions options;
  options.kind = "fem";
  options.solver.threads = 1;
  return options;
}

Observation pressing(const Scene& scene, const Vec3& translation) {
  Observation observation;
  observation.resize_for(scene);
  observation.probes[0].seen = true;
  observation.probes[0].tissue_T_probe.translation = translation;
  return observation;
}

// N: a stiff sphere into a half space, 4/3 E/(1 - nu^2) sqrt(R) depth^(3/2).
double hertz_force(const Material& material, double radius, double depth) {
  const double stiffness = material.youngs_modulus / (1.0 - material.poissons_ratio * material.poissons_ratio);
  return 4.0 / 3.0 * stiffness * std::sqrt(radius) * std::pow(depth, 1.5) / kMillinewtonPerNewton;
}

// By how much a layer of this thickness on a rigid ground is stiffer than the half space: Dimitriadis et al., Biophys.
// J. 82 (2002), 2798, equation (12) for a bonded layer, to second order.
double layer_factor(const Material& material, double radius, double depth, double thickness) {
  const double nu = material.poissons_ratio;
  const double alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
  const double term = -2.0 * alpha / std::numbers::pi * std::sqrt(radius * depth) / thickness;
  return 1.0 + term + term * term;
}

}  // namespace

// The block is 16 contact radii wide and 8 deep; the latter alone makes it 12 % stiffer than a half space.
TEST_CASE("a sphere on a large block pushes with Hertz's force", "[contact][fem]") {
  constexpr double kRadius = 30.0, kDepth = 1.2;  // mm
  Scene scene = box_scene({10, 10, 5, 9.6}, 0);
  scene.targets.clear();
  scene.material.poissons_ratio = 0.3;
  // Nodes crowd under the sphere: a contact radius, 6 mm, is two elements' edges.
  const double half = 48.0;
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    const auto crowded = [&](double x) {
      const double s = (x - half) / half;
      return half * s * (0.35 + 0.65 * std::abs(s));
    };
    const Vec3 p = scene.mesh.node(i);
    const double below = (half - p.z()) / half;
    scene.mesh.rest.row(i) = Vec3(crowded(p.x()), crowded(p.y()), -half * below * (0.35 + 0.65 * below)).transpose();
  }
  for (Pad& pad : scene.pads) pad.center.setZero();
  scene.probes.push_back({"ball", {Vec3::Zero(), Vec3::Constant(kRadius), kRadius}, 0.0});
  const auto simulator = make_simulator(scene, fem_options());
  const StepReport report = simulator->step(pressing(scene, Vec3(0.0, 0.0, kRadius - kDepth)));
  REQUIRE(report.converged);
  CHECK(report.penetration < 1e-3);
  CHECK(report.contacts > 4);
  const Vec3 force = simulator->probe_force(0);
  const double hertz =
      hertz_force(scene.material, kRadius, kDepth) * layer_factor(scene.material, kRadius, kDepth, half);
  CHECK(-force.z() == Approx(hertz).epsilon(0.07));
  CHECK(force.head<2>().norm() < 0.03 * force.norm());
}

TEST_CASE("finite elements under a probe: pressed, converged, and at rest again when it lifts off", "[contact][fem]") {
  Scene scene = box_scene({6, 4, 2, 10.0});
  scene.probes.push_back({"probe", {Vec3::Zero(), Vec3(12.0, 8.0, 10.0), 3.0}, 0.0});
  const auto simulator = make_simulator(scene, fem_options());
  const NodeField rest = simulator->positions();
  const Vec3 place(30.0, 20.0, 20.0 - 3.0 + 10.0);
  StepReport report = simulator->step(pressing(scene, place));
  REQUIRE(report.converged);
  CHECK(report.pad_ramp == 0.0);
  CHECK(report.penetration < 1e-3);
  CHECK(simulator->probe_force(0).z() < -0.05);
  for (Eigen::Index i = 0; i < simulator->positions().rows(); ++i) {
    const Vec3 p = simulator->positions().row(i).head<3>().transpose();
    CHECK(signed_distance(scene.probes[0].shape, p - place).distance > -1e-3);
  }
  report = simulator->step(pressing(scene, place + Vec3(0.0, 0.0, 20.0)));
  REQUIRE(report.converged);
  CHECK(report.contacts == 0);
  CHECK(simulator->probe_force(0).norm() == 0.0);
  CHECK((simulator->positions() - rest).rowwise().norm().maxCoeff() < 1e-4);
}

TEST_CASE("fem says that its probes have no friction", "[contact][fem]") {
  Scene scene = box_scene({3, 2, 2, 10.0});
  scene.probes.push_back({"US", {}, 0.1});
  CHECK_THROWS_WITH(make_simulator(scene, fem_options()),
                    "probe US has friction, and the simulator fem has none: set its friction to 0");
}
