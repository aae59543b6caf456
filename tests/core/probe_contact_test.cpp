// Probes that press, slide and lift off, as whoever steps admm and kf-admm sees them.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/neo_hookean.hpp"
#include "core/simulator.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kTop = 20.0;  // mm, of the box below

// A box 60 x 40 x 20 mm with a probe whose face is 12 x 8 mm with rounded edges.
Scene probed_scene(double friction = 0.0) {
  Scene scene = box_scene({12, 8, 4, 5.0});
  scene.probes.push_back({"probe", {Vec3::Zero(), Vec3(6.0, 4.0, 10.0), 2.0}, friction});
  return scene;
}

SimulatorOptions options_of(const std::string& kind) {
  SimulatorOptions options;
  options.kind = kind;
  options.solver.threads = 1;
  return options;
}

// Markers where the simulation has them, so that nothing is corrected; pads off, probe lifted.
Observation observation_of(const Simulator& simulator) {
  Observation observation;
  observation.resize_for(simulator.scene());
  for (std::size_t i = 0; i < observation.markers.size(); ++i)
    observation.markers[i] = simulator.marker(static_cast<int>(i));
  observation.marker_seen.assign(observation.markers.size(), 1);
  return observation;
}

// The probe's face `depth` mm below the top of the undeformed box at (x, y).
ProbeInput pressed_at(double x, double y, double depth) {
  ProbeInput input;
  input.seen = true;
  input.tissue_T_probe.translation = Vec3(x, y, kTop - depth + 10.0);
  return input;
}

// mm, over all nodes of the body, by another way than the simulator's.
double deepest_node(const Scene& scene, const NodeField& x, const ProbeInput& input, int probe = 0) {
  double deepest = 0.0;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Vec3 p = input.tissue_T_probe.inverse()(Vec3(x.row(i).head<3>().transpose()));
    deepest = std::max(deepest, -signed_distance(scene.probes[static_cast<std::size_t>(probe)].shape, p).distance);
  }
  return deepest;
}

StepReport settle(Simulator& simulator, const ProbeInput& input, int frames) {
  StepReport report;
  for (int frame = 0; frame < frames; ++frame) {
    Observation observation = observation_of(simulator);
    observation.probes[0] = input;
    report = simulator.step(observation);
  }
  return report;
}

// N, by (11) at every node of linear tetrahedra.
Eigen::MatrixX3d elastic_forces(const Scene& scene, const NodeField& x) {
  Eigen::MatrixX3d force = Eigen::MatrixX3d::Zero(x.rows(), 3);
  for (const Tet& tet : scene.mesh.tets) {
    Mat3 rest, now;
    for (int k = 0; k < 3; ++k) {
      rest.col(k) = scene.mesh.node(tet[k + 1]) - scene.mesh.node(tet[0]);
      now.col(k) = (x.row(tet[k + 1]) - x.row(tet[0])).head<3>().transpose();
    }
    const Mat3 stress = first_piola(scene.material, now * rest.inverse());
    const Mat3 corners = rest.determinant() / 6.0 * stress * rest.inverse().transpose() / kMillinewtonPerNewton;
    for (int k = 0; k < 3; ++k) {
      force.row(tet[k + 1]) += corners.col(k).transpose();
      force.row(tet[0]) -= corners.col(k).transpose();
    }
  }
  return force;
}

double furthest(const NodeField& a, const NodeField& b) { return (a - b).rowwise().norm().maxCoeff(); }

constexpr double kPenetration = 0.02;  // mm, while the probe moves by 0.5 mm a frame

}  // namespace

TEST_CASE("a probe that does not reach the skin changes nothing", "[contact]") {
  Scene scene = probed_scene();
  const auto with = make_simulator(scene, options_of("admm"));
  scene.probes.clear();
  const auto without = make_simulator(scene, options_of("admm"));
  for (int frame = 0; frame < 30; ++frame) {
    Observation observation = observation_of(*without);
    observation.pads[0].kind = PadInput::Kind::pose;
    observation.pads[0].center = scene.pads[0].center - Vec3(0.0, 0.0, 0.1 * frame);
    const StepReport report = without->step(observation);
    observation.probes.push_back(pressed_at(50.0, 20.0, -2.5));  // near enough to be looked at, above the bulge
    const StepReport probed = with->step(observation);
    CHECK(probed.contacts == 0);
    CHECK(probed.iterations == report.iterations);
  }
  CHECK(with->state_hash() == without->state_hash());
}

TEST_CASE("the skin stays outside of a probe that presses, slides and turns, and is only pushed", "[contact]") {
  const std::string kind = GENERATE("admm", "kf-admm");
  const double friction = GENERATE(0.0, 0.4);
  const Scene scene = probed_scene(friction);
  const auto simulator = make_simulator(scene, options_of(kind));
  int touched = 0;
  for (int frame = 0; frame < 120; ++frame) {
    const double depth = 5.0 * std::sin(3.14159 * frame / 120.0);
    ProbeInput input = pressed_at(20.0 + 0.15 * frame, 20.0, depth);
    input.tissue_T_probe.rotation =
        (Eigen::AngleAxisd(0.002 * frame, Vec3::UnitY()) * Eigen::AngleAxisd(0.01 * frame, Vec3::UnitZ()))
            .toRotationMatrix();
    Observation observation = observation_of(*simulator);
    observation.probes[0] = input;
    const StepReport report = simulator->step(observation);
    REQUIRE(report.finite);
    CHECK(report.inverted == 0);
    CHECK(deepest_node(scene, simulator->positions(), input) <= kPenetration);
    CHECK(report.penetration <= kPenetration);
    CHECK(simulator->probe_force(0).z() <= 0.0);  // of the probe on the tissue, which lies below it
    if (report.contacts == 0) CHECK(simulator->probe_force(0).norm() == 0.0);
    touched += report.contacts > 0 ? 1 : 0;
  }
  CHECK(touched > 100);
}

TEST_CASE("a probe that lifts off leaves nothing behind", "[contact]") {
  const Scene scene = probed_scene(GENERATE(0.0, 0.4));
  const auto simulator = make_simulator(scene, options_of("admm"));
  const NodeField rest = simulator->positions();
  CHECK(settle(*simulator, pressed_at(30.0, 20.0, 4.0), 60).contacts > 0);
  CHECK(furthest(simulator->positions(), rest) > 3.5);
  ProbeInput lifted = pressed_at(30.0, 20.0, -20.0);
  SECTION("by its pose") {}
  SECTION("by not being seen") { lifted.seen = false; }
  const StepReport report = settle(*simulator, lifted, 600);
  CHECK(report.contacts == 0);
  CHECK(simulator->probe_force(0).norm() == 0.0);
  CHECK(furthest(simulator->positions(), rest) < 1e-3);
}

// By the stress of the tetrahedra alone: neither the simulator's forces nor its factor are asked.
TEST_CASE("what a probe without friction pushes is normal to it, balanced by the support, and the rest is in balance",
          "[contact]") {
  const Scene scene = probed_scene();
  SimulatorOptions options = options_of("admm");
  options.solver.element = Element::p1;
  options.solver.iterations = 50;
  const auto simulator = make_simulator(scene, options);
  const ProbeInput input = pressed_at(27.0, 19.0, 3.0);
  const StepReport report = settle(*simulator, input, 300);
  const Eigen::MatrixX3d force = elastic_forces(scene, simulator->positions());
  const Vec3 push = simulator->probe_force(0);
  CHECK(report.penetration < 1e-4);
  CHECK(push.z() < -0.1);
  Vec3 base = Vec3::Zero(), top = Vec3::Zero();
  double unbalanced = 0.0;
  for (int node = 0; node < scene.mesh.node_count(); ++node) {
    const Vec3 f = force.row(node).transpose();
    if (scene.mesh.node(node).z() < 1e-9) {
      base += f;
    } else if (std::abs(scene.mesh.node(node).z() - kTop) < 1e-9) {
      top += f;
    } else {
      unbalanced = std::max(unbalanced, f.norm());
    }
  }
  CHECK(unbalanced < 1e-3 * push.norm());
  CHECK((top - push).norm() < 1e-2 * push.norm());
  CHECK((base + push).norm() < 1e-2 * push.norm());
}

TEST_CASE("friction stays inside of its cone, and on it while the skin slides", "[contact]") {
  constexpr double kFriction = 0.3;
  Scene scene = probed_scene(kFriction);
  scene.probes[0].shape = {Vec3::Zero(), Vec3(60.0, 50.0, 10.0), 1.0};  // its face covers all of the top
  scene.mesh = box_scene({8, 6, 3, 20.0 / 3.0}).mesh;
  const auto simulator = make_simulator(scene, options_of("admm"));
  const double depth = 1.0;
  settle(*simulator, pressed_at(30.0, 20.0, depth), 100);
  const NodeField before = simulator->positions();
  // Slowly sideways: at first the skin sticks to the face.
  settle(*simulator, pressed_at(30.05, 20.0, depth), 50);
  Vec3 force = simulator->probe_force(0);
  CHECK(force.x() > 0.0);
  CHECK(force.head<2>().norm() < 0.99 * kFriction * -force.z());
  for (int node = 0; node < scene.mesh.node_count(); ++node) {
    const Vec3 rest = scene.mesh.node(node);
    const bool inner = std::abs(rest.x() - 30.0) < 20.0 && std::abs(rest.y() - 20.0) < 12.0;
    if (rest.z() == kTop && inner)
      CHECK(simulator->positions()(node, 0) - before(node, 0) == Approx(0.05).margin(0.01));
  }
  for (int step = 1; step <= 100; ++step) {
    settle(*simulator, pressed_at(30.05 + 0.1 * step, 20.0, depth), 2);
    force = simulator->probe_force(0);
    CHECK(force.head<2>().norm() <= kFriction * -force.z() * (1.0 + 1e-9));
  }
  // The skin spreads under the load, so that not all of it slides the same way.
  CHECK(force.head<2>().norm() > 0.95 * kFriction * -force.z());
  CHECK(std::abs(force.y()) < 0.05 * force.x());
}

TEST_CASE("a pad and a probe at once: the pad's nodes are where it is, the skin is outside of the probe", "[contact]") {
  const std::string kind = GENERATE("admm", "kf-admm");
  const Scene scene = probed_scene();
  SimulatorOptions options = options_of(kind);
  SECTION("glued") {}
  SECTION("a pad that slides and a support that is loose in part") { options.effects = many_effects(scene); }
  const auto simulator = make_simulator(scene, options);
  const std::vector<int> nodes = nodes_of(*scene.mesh.find_surface("A1"));
  Vec3 center = Vec3::Zero();
  for (int node : nodes) center += scene.mesh.node(node) / static_cast<double>(nodes.size());
  // Its face begins 4 mm beside the pad.
  double edge = 0.0;
  for (int node : nodes) edge = std::max(edge, scene.mesh.node(node).x());
  for (int frame = 0; frame < 80; ++frame) {
    const double depth = 0.04 * frame;
    Observation observation = observation_of(*simulator);
    observation.pads[0].kind = PadInput::Kind::pose;
    observation.pads[0].center = scene.pads[0].center - Vec3(0.0, 0.0, depth);
    observation.probes[0] = pressed_at(edge + 10.0, center.y(), 1.2 * depth);
    const StepReport report = simulator->step(observation);
    CHECK(report.penetration <= kPenetration);
    CHECK(deepest_node(scene, simulator->positions(), observation.probes[0]) <= kPenetration);
    if (!options.effects.empty()) continue;
    for (int node : nodes) {
      const Vec3 at = simulator->positions().row(node).head<3>().transpose();
      CHECK((at - scene.mesh.node(node) + Vec3(0.0, 0.0, depth)).norm() < 1e-9);
    }
  }
}

TEST_CASE("a probe that jumps is ramped and ends where one ends that came slowly", "[contact]") {
  const Scene scene = probed_scene();
  const auto slow = make_simulator(scene, options_of("admm")), sudden = make_simulator(scene, options_of("admm"));
  for (int frame = 0; frame <= 80; ++frame) settle(*slow, pressed_at(30.0, 20.0, 0.1 * frame), 1);
  settle(*slow, pressed_at(30.0, 20.0, 8.0), 300);
  const ProbeInput deep = pressed_at(30.0, 20.0, 8.0);
  SECTION("out of nowhere") { CHECK(settle(*sudden, deep, 1).pad_ramp > 3.0); }
  SECTION("from a light press") {
    settle(*sudden, pressed_at(30.0, 20.0, 1.0), 5);
    CHECK(settle(*sudden, deep, 1).pad_ramp == Approx(4.0));
  }
  const StepReport report = settle(*sudden, deep, 300);
  CHECK(report.pad_ramp == 0.0);
  CHECK(report.inverted == 0);
  CHECK(furthest(slow->positions(), sudden->positions()) < 0.01);
  CHECK((slow->probe_force(0) - sudden->probe_force(0)).norm() < 0.01 * slow->probe_force(0).norm());
}

TEST_CASE("a pose that is no pose is reported and changes nothing", "[contact]") {
  const std::string kind = GENERATE("admm", "kf-admm");
  const Scene scene = probed_scene();
  const auto simulator = make_simulator(scene, options_of(kind));
  settle(*simulator, pressed_at(30.0, 20.0, 2.0), 20);
  ProbeInput bad = pressed_at(30.0, 20.0, 2.0);
  const int what = GENERATE(range(0, 5));
  if (what == 0) bad.tissue_T_probe.translation.y() = std::numeric_limits<double>::quiet_NaN();
  if (what == 1) bad.tissue_T_probe.translation.z() = std::numeric_limits<double>::infinity();
  if (what == 2) bad.tissue_T_probe.translation.x() = 1e300;
  if (what == 3) bad.tissue_T_probe.rotation *= 2.0;
  if (what == 4) bad.tissue_T_probe.rotation(2, 1) = std::numeric_limits<double>::quiet_NaN();
  const std::uint64_t before = simulator->state_hash();
  const StepReport report = settle(*simulator, bad, 3);
  CHECK_FALSE(report.finite);
  CHECK_FALSE(report.converged);
  CHECK(simulator->state_hash() == before);
  CHECK(settle(*simulator, pressed_at(30.0, 20.0, 2.0), 20).finite);
}

TEST_CASE("a probe that goes through the whole body is survived", "[contact]") {
  const Scene scene = probed_scene();
  const auto simulator = make_simulator(scene, options_of(GENERATE("admm", "kf-admm")));
  const NodeField rest = simulator->positions();
  for (int frame = 0; frame < 60; ++frame) {
    const StepReport report = settle(*simulator, pressed_at(30.0, 20.0, 0.5 * frame), 1);
    CHECK(report.finite);
    CHECK(simulator->positions().allFinite());
  }
  settle(*simulator, pressed_at(30.0, 20.0, -30.0), 1500);
  CHECK(furthest(simulator->positions(), rest) < 0.1);
}

TEST_CASE("what markers say does not push tissue through the probe", "[contact]") {
  SimulatorOptions options = options_of("kf-admm");
  options.filter.preset = GENERATE(NoisePreset::paper, NoisePreset::force, NoisePreset::standard);
  options.solver.scheme = GENERATE(Scheme::per_frame, Scheme::algorithm_1);
  const Scene scene = probed_scene();
  const auto simulator = make_simulator(scene, options);
  const Vec3 wrong(GENERATE(-2.0, 2.0), 0.0, 2.0);  // mm: markers say that all of the skin is higher, and aside
  const ProbeInput input = pressed_at(30.0, 20.0, 3.0);
  settle(*simulator, input, 30);
  Observation observation = observation_of(*simulator);
  for (Vec3& marker : observation.markers) marker += wrong;
  observation.probes[0] = input;
  for (int frame = 0; frame < 60; ++frame) {
    const StepReport report = simulator->step(observation);
    CHECK(report.markers_used > 0);
    CHECK(deepest_node(scene, simulator->positions(), input) <= 0.05);
  }
}
