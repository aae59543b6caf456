// The simulator pbd as whoever steps it sees it.
#include "core/pbd_simulator.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr BoxSize kBlock{6, 5, 4, 10.0};  // 60 x 50 x 40 mm: 12 x 10 x 8 particles
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

SimulatorOptions options_of(const PbdOptions& pbd = {}) {
  SimulatorOptions options;
  options.kind = "pbd";
  options.pbd = pbd;
  return options;
}

Observation lifted(const Scene& scene) {
  Observation observation;
  observation.resize_for(scene);
  observation.dt = 0.02;
  return observation;
}

void push(Observation& observation, const Scene& scene, int pad, const Vec3& way) {
  observation.pads[pad].kind = PadInput::Kind::pose;
  observation.pads[pad].center = scene.pads[pad].center + way;
}

Scene probe_scene() {
  Scene scene = box_scene(kBlock, 0);
  scene.pads.clear();
  Probe probe;
  probe.name = "probe";
  probe.shape.half_extents = Vec3(12.0, 10.0, 30.0);
  scene.probes = {probe};
  return scene;
}

// The probe above the middle of the block's top, its face `depth` mm below the skin.
ProbeInput pressed(double depth, const Vec3& aside = Vec3::Zero()) {
  return {true, {Mat3::Identity(), Vec3(30.0, 25.0, 40.0 + 30.0 - depth) + aside}};
}

double least_distance(const PbdSimulator& simulator, const ProbeInput& probe) {
  double least = 1e9;
  const RigidTransform probe_T_tissue = probe.tissue_T_probe.inverse();
  for (Eigen::Index i = 0; i < simulator.state().x.rows(); ++i)
    least = std::min(least, signed_distance(simulator.scene().probes[0].shape,
                                            probe_T_tissue(simulator.state().x.row(i).head<3>().transpose()))
                                .distance);
  return least;
}

double furthest_from_rest(const PbdSimulator& simulator) {
  return (simulator.state().x - simulator.model().rest).rowwise().norm().maxCoeff();
}

}  // namespace

TEST_CASE("rest stays rest, and the base is held", "[pbd]") {
  const Scene scene = box_scene(kBlock);
  PbdSimulator simulator(scene, options_of());
  CHECK(simulator.model().lattice.count() == 12 * 10 * 8);
  int held = 0;
  for (std::size_t i = 0; i < simulator.model().mobility.size(); ++i) {
    const bool lowest = simulator.model().lattice.rest(static_cast<int>(i)).z() < 2.6;
    CHECK((simulator.model().mobility[i] == 0.0) == lowest);
    held += lowest ? 1 : 0;
  }
  CHECK(held == 120);
  CHECK(simulator.model().particle_mass == Approx(125e-6));
  StepReport report;
  for (int frame = 0; frame < 200; ++frame) report = simulator.step(lifted(scene));
  CHECK(report.converged);
  CHECK(report.finite);
  CHECK(report.iterations == 27);
  CHECK(furthest_from_rest(simulator) < 1e-9);
  for (int t = 0; t < 3; ++t) {
    CHECK((simulator.target(t).position - scene.targets[t].rest).norm() < 1e-9);
    CHECK(simulator.target(t).covariance == Mat3::Zero());
  }
  for (int m = 0; m < 7; ++m) CHECK((simulator.marker(m) - scene.markers[m].rest).norm() < 1e-9);
  CHECK((simulator.positions().leftCols<3>() - scene.mesh.rest).norm() < 1e-9);
}

TEST_CASE("free fall is symplectic Euler with damping, in closed form", "[pbd]") {
  // Nothing holds particles together without stiffness. They fall with the first frame, as a pad's force does: under
  // gravity they would before.
  Scene scene = box_scene(kBlock, 0);
  PbdOptions options;
  options.cluster_stiffness = 0.0;
  options.self_collision = false;
  PbdSimulator simulator(scene, options_of(options));
  Observation observation = lifted(scene);
  const double force = -0.02;  // N
  observation.pads[0].kind = PadInput::Kind::force;
  observation.pads[0].force = Vec3(0.0, 0.0, force);
  const std::vector<int>& pushed = simulator.model().pad_particles[0];
  const double a = force * 1e3 / (125e-6 * static_cast<double>(pushed.size()));
  const double c = 12.0, h = 0.02 / 3.0;
  for (int frame = 1; frame <= 10; ++frame) {
    simulator.step(observation);
    const int n = 3 * frame;
    const double q = 1.0 - c * h;
    const double v = a / c * (1.0 - std::pow(q, n));
    const double z = a / c * h * (n - q * (1.0 - std::pow(q, n)) / (1.0 - q));
    for (int i : pushed) {
      CHECK(simulator.state().v(i, 2) == Approx(v));
      CHECK(simulator.state().x(i, 2) - simulator.model().rest(i, 2) == Approx(z));
    }
  }
}

TEST_CASE("a pad's particles follow its pose exactly, and are released with it", "[pbd]") {
  const Scene scene = box_scene(kBlock);
  PbdSimulator simulator(scene, options_of());
  Observation observation = lifted(scene);
  push(observation, scene, 0, Vec3(2.0, 1.0, -6.0));
  observation.pads[0].rotation = Eigen::AngleAxisd(0.2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const std::vector<int>& glued = simulator.model().pad_particles[0];
  REQUIRE(glued.size() > 20);
  for (int frame = 0; frame < 3; ++frame) {
    simulator.step(observation);
    for (int i : glued) {
      const Vec3 there = observation.pads[0].center +
                         observation.pads[0].rotation * (simulator.model().lattice.rest(i) - scene.pads[0].center);
      CHECK((simulator.state().x.row(i).head<3>().transpose() - there).norm() < 1e-9);
    }
  }
  for (int i = 0; i < simulator.model().lattice.count(); ++i)
    if (simulator.model().mobility[static_cast<std::size_t>(i)] == 0.0)
      CHECK(simulator.state().x.row(i) == simulator.model().rest.row(i));
  observation.pads[0].kind = PadInput::Kind::absent;
  StepReport report;
  for (int frame = 0; frame < 500; ++frame) report = simulator.step(observation);
  CHECK(report.converged);
  CHECK(furthest_from_rest(simulator) < 0.02);
  CHECK(simulator.pad_force(0) == Vec3::Zero());
}

TEST_CASE("where pads share particles these follow the first", "[pbd]") {
  const Scene scene = box_scene(kBlock);
  PbdSimulator simulator(scene, options_of());
  const auto& pads = simulator.model().pad_particles;
  std::vector<int> both;
  std::set_intersection(pads[0].begin(), pads[0].end(), pads[1].begin(), pads[1].end(), std::back_inserter(both));
  REQUIRE_FALSE(both.empty());
  Observation observation = lifted(scene);
  push(observation, scene, 0, Vec3(0, 0, -2));
  push(observation, scene, 1, Vec3(0, 0, -4));
  simulator.step(observation);
  for (int i : both) CHECK(simulator.state().x(i, 2) == Approx(simulator.model().rest(i, 2) - 2.0));
}

TEST_CASE("what has come to rest has converged, where constraints pull against each other, too", "[pbd]") {
  const Scene scene = box_scene(kBlock);
  PbdSimulator simulator(scene, options_of());
  Observation observation = lifted(scene);
  StepReport report;
  for (int frame = 0; frame < 300; ++frame) {
    push(observation, scene, 0, Vec3(0, 0, -std::min(22.0, 0.4 * frame)));
    report = simulator.step(observation);
  }
  REQUIRE(simulator.state().v.rowwise().norm().maxCoeff() < 0.1);
  CHECK(report.converged);
  CHECK(report.dual_residual < 1e-3);
  push(observation, scene, 0, Vec3(0, 0, 20.0));
  CHECK_FALSE(simulator.step(observation).converged);
}

TEST_CASE("a probe that presses does not go in, and lets go when it lifts", "[pbd]") {
  const Scene scene = probe_scene();
  PbdSimulator simulator(scene, options_of());
  Observation observation = lifted(scene);
  // In by 10 mm at 20 mm/s, held, out.
  for (int frame = 0; frame < 50; ++frame) {
    observation.probes[0] = pressed(std::min(10.0, 0.4 * frame));
    REQUIRE(simulator.step(observation).finite);
    // Contact has the last word in an iteration: friction on a rounded edge is all that is left.
    CHECK(least_distance(simulator, observation.probes[0]) > 3.0 - 0.05);
  }
  CHECK(simulator.target(1).position.z() < scene.targets[1].rest.z() - 1.0);
  CHECK(least_distance(simulator, observation.probes[0]) < 3.0 + 0.05);
  for (int frame = 0; frame < 400; ++frame) {
    observation.probes[0] = pressed(10.0 - 0.4 * frame);
    simulator.step(observation);
  }
  CHECK(least_distance(simulator, observation.probes[0]) > 50.0);
  CHECK(furthest_from_rest(simulator) < 0.05);
  // Not seen, it does not touch.
  observation.probes[0] = pressed(10.0);
  observation.probes[0].seen = false;
  simulator.step(observation);
  CHECK(furthest_from_rest(simulator) < 0.05);
}

TEST_CASE("a probe drags the skin with friction and glides without", "[pbd]") {
  // Wider than the block: no edge of it catches.
  Scene scene = probe_scene();
  scene.probes[0].shape.half_extents = Vec3(90.0, 90.0, 30.0);
  const auto dragged = [&](double friction) {
    PbdOptions options;
    options.shape_friction = friction;
    PbdSimulator simulator(scene, options_of(options));
    Observation observation = lifted(scene);
    for (int frame = 0; frame < 60; ++frame) {
      observation.probes[0] = pressed(std::min(5.0, 0.25 * frame), Vec3(frame < 30 ? 0.0 : 0.1 * (frame - 30), 0, 0));
      simulator.step(observation);
    }
    const int middle = simulator.model().lattice.nearest({30.0, 25.0, 40.0});
    return simulator.state().x(middle, 0) - simulator.model().rest(middle, 0);
  };
  const double free = dragged(0.0), some = dragged(0.05), firm = dragged(5.0);
  CHECK(std::abs(free) < 0.6);
  CHECK(firm == Approx(2.9).margin(0.2));
  CHECK(some > free);
  CHECK(some < firm);
}

TEST_CASE("substeps follow the measured time", "[pbd]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  PbdSimulator simulator(scene, options_of());
  Observation observation = lifted(scene);
  int iterations = 0;
  double time = 0.0;
  std::mt19937 generator(53);
  for (int frame = 0; frame < 300; ++frame) {
    observation.dt = 0.01 * (1.0 + 0.99 * symmetric_random(generator));
    time += observation.dt;
    iterations += simulator.step(observation).iterations;
    CHECK(std::abs(iterations / 9 - time * 150.0) <= 1.0);
  }
  observation.dt = 10.0;
  CHECK(simulator.step(observation).iterations == 5 * 27);
  observation.dt = 0.0;
  CHECK(simulator.step(observation).iterations == 0);
  observation.dt = -1.0;
  CHECK(simulator.step(observation).iterations == 0);
}

TEST_CASE("how frames cut the time matters little to where a push ends", "[pbd]") {
  const Scene scene = box_scene(kBlock);
  const auto pushed = [&](double dt) {
    PbdSimulator simulator(scene, options_of());
    Observation observation = lifted(scene);
    observation.dt = dt;
    const int frames = static_cast<int>(std::lround(6.0 / dt));
    for (int frame = 0; frame < frames; ++frame) {
      push(observation, scene, 0, Vec3(0, 0, -std::min(6.0, 10.0 * frame * dt)));
      simulator.step(observation);
    }
    return simulator.target(1).position;
  };
  const Vec3 usual = pushed(0.02);
  CHECK((usual - scene.targets[1].rest).norm() > 0.5);
  CHECK((pushed(0.004) - usual).norm() < 0.02);
  CHECK((pushed(0.013) - usual).norm() < 0.02);
}

TEST_CASE("under gravity a body hangs before anything is recorded, and stays so", "[pbd]") {
  Scene scene = box_scene(kBlock);
  scene.gravity = Vec3(0.0, 0.0, -1.0);
  PbdSimulator simulator(scene, options_of());
  const double sunk = scene.targets[0].rest.z() - simulator.target(0).position.z();
  CHECK(sunk > 0.0);
  const Vec3 before = simulator.target(0).position;
  for (int frame = 0; frame < 100; ++frame) simulator.step(lifted(scene));
  CHECK((simulator.target(0).position - before).norm() < 0.02);
}

TEST_CASE("equal inputs make equal hashes, and reset forgets everything", "[pbd]") {
  Scene scene = box_scene({4, 3, 2, 10.0});
  scene.probes = probe_scene().probes;
  const auto run = [&](PbdSimulator& simulator) {
    std::vector<std::uint64_t> hashes;
    Observation observation = lifted(scene);
    for (int frame = 0; frame < 40; ++frame) {
      observation.dt = 0.007 + 0.001 * (frame % 5);
      if (frame % 10 < 7) push(observation, scene, frame % 2, Vec3(0, 0.1, -0.1 * frame));
      if (frame % 10 == 9) observation.pads[0].kind = PadInput::Kind::force;
      observation.pads[0].force = Vec3(0, 0, -0.01);
      observation.probes[0] = pressed(20.0 + 0.1 * frame);
      observation.probes[0].seen = frame > 20;
      simulator.step(observation);
      hashes.push_back(simulator.state_hash());
    }
    return hashes;
  };
  PbdSimulator one(scene, options_of()), other(scene, options_of());
  const std::uint64_t rest = one.state_hash();
  const std::vector<std::uint64_t> hashes = run(one);
  CHECK(hashes == run(other));
  for (std::size_t i = 1; i < hashes.size(); ++i) CHECK(hashes[i] != hashes[i - 1]);
  one.reset();
  CHECK(one.state_hash() == rest);
  CHECK(run(one) == hashes);
}

TEST_CASE("inputs that are not finite are refused, and what explodes holds the last finite state", "[pbd]") {
  Scene scene = box_scene({4, 3, 2, 10.0});
  scene.probes = probe_scene().probes;
  PbdSimulator simulator(scene, options_of());
  Observation observation = lifted(scene);
  push(observation, scene, 0, Vec3(0, 0, -1));
  for (int frame = 0; frame < 5; ++frame) REQUIRE(simulator.step(observation).finite);
  const std::uint64_t before = simulator.state_hash();
  const NodeField x = simulator.state().x;
  Observation bad = observation;
  SECTION("pose") { bad.pads[0].center.z() = kNaN; }
  SECTION("turn") { bad.pads[0].rotation(0, 1) = kNaN; }
  SECTION("force") {
    bad.pads[1].kind = PadInput::Kind::force;
    bad.pads[1].force.x() = std::numeric_limits<double>::infinity();
  }
  SECTION("probe") {
    bad.probes[0].seen = true;
    bad.probes[0].tissue_T_probe.translation.x() = kNaN;
  }
  SECTION("time") { bad.dt = kNaN; }
  CHECK_FALSE(simulator.step(bad).finite);
  CHECK(simulator.state_hash() == before);
  bad = observation;
  bad.pads[0].center.z() = 1e200;
  CHECK_FALSE(simulator.step(bad).finite);
  CHECK(simulator.state().x == x);
  bad = observation;
  bad.markers[0].x() = kNaN;
  bad.marker_seen[0] = 1;
  CHECK(simulator.step(bad).finite);
  CHECK(simulator.target(0).position.allFinite());
}

TEST_CASE("a scene that has no particle where one is needed is refused in words", "[pbd]") {
  const auto refusal = [](const Scene& scene, const PbdOptions& options) -> std::string {
    try {
      PbdSimulator simulator(scene, options_of(options));
    } catch (const ModelError& error) {
      return error.what();
    }
    return "";
  };
  Scene scene = box_scene({4, 3, 2, 10.0});
  scene.fixed_surface = "nowhere";
  CHECK(refusal(scene, {}).find("nowhere") != std::string::npos);
  scene = box_scene({4, 3, 2, 10.0});
  scene.pads[1].surface = "A9";
  CHECK(refusal(scene, {}).find("A9") != std::string::npos);
  PbdOptions coarse;
  coarse.particle_spacing = 45.0;
  CHECK(refusal(box_scene({4, 3, 2, 10.0}), coarse).find("pad A1") != std::string::npos);
}
