#include "core/rigid_simulator.hpp"

#include <catch2/catch.hpp>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

SimulatorOptions options_of(RigidOptions::Follow follow) {
  SimulatorOptions options;
  options.kind = "rigid";
  options.rigid.follow = follow;
  return options;
}

Observation seen_at(const Scene& scene, const RigidTransform& motion) {
  Observation observation;
  observation.resize_for(scene);
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    observation.markers[i] = motion(scene.markers[i].rest);
    observation.marker_seen[i] = 1;
  }
  return observation;
}

RigidTransform random_motion(unsigned seed) {
  std::mt19937 generator(seed);
  const Mat3 turn = random_rotation(generator);
  return {turn, 20.0 * random_vector(generator)};
}

}  // namespace

TEST_CASE("a rigid body that follows nothing stays at rest", "[rigid]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const auto simulator = make_simulator(scene, options_of(RigidOptions::Follow::none));
  Observation observation = seen_at(scene, random_motion(1));
  observation.pads[0].kind = PadInput::Kind::pose;
  observation.pads[0].center = scene.pads[0].center + Vec3(0, 0, -9);
  const std::uint64_t rest = simulator->state_hash();
  const StepReport report = simulator->step(observation);
  CHECK(report.converged);
  CHECK(report.markers_used == 0);
  CHECK(simulator->state_hash() == rest);
  CHECK((simulator->positions().leftCols<3>() - scene.mesh.rest).norm() == 0.0);
  for (int t = 0; t < 3; ++t) {
    CHECK(simulator->target(t).position == scene.targets[t].rest);
    CHECK(simulator->target(t).covariance == Mat3::Zero());
  }
  CHECK(simulator->pad_force(0) == Vec3::Zero());
}

TEST_CASE("a rigid body that follows markers moves as they do", "[rigid]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const auto simulator = make_simulator(scene, options_of(RigidOptions::Follow::markers));
  const RigidTransform motion = random_motion(2);
  const StepReport report = simulator->step(seen_at(scene, motion));
  CHECK(report.markers_used == 7);
  CHECK(report.innovation_rms < 1e-9);
  for (int t = 0; t < 3; ++t) CHECK((simulator->target(t).position - motion(scene.targets[t].rest)).norm() < 1e-9);
  for (int m = 0; m < 7; ++m) CHECK((simulator->marker(m) - motion(scene.markers[m].rest)).norm() < 1e-9);
  for (int i = 0; i < scene.mesh.node_count(); ++i)
    CHECK((simulator->positions().row(i).head<3>().transpose() - motion(scene.mesh.node(i))).norm() < 1e-9);
  simulator->reset();
  CHECK(simulator->target(0).position == scene.targets[0].rest);
}

TEST_CASE("markers that do not determine a motion leave the body where it was", "[rigid]") {
  Scene scene = box_scene({3, 2, 2, 10.0}, 3);
  // The last three lie on a line.
  for (int k = 0; k < 3; ++k) scene.markers.push_back({"on line", Vec3(10.0 * k, 0.0, 10.0)});
  const auto simulator = make_simulator(scene, options_of(RigidOptions::Follow::markers));
  simulator->step(seen_at(scene, random_motion(3)));
  const std::uint64_t before = simulator->state_hash();
  Observation observation = seen_at(scene, random_motion(4));
  SECTION("two") { observation.marker_seen = {1, 1, 0, 0, 0, 0}; }
  SECTION("none") { observation.marker_seen.assign(6, 0); }
  SECTION("on a line") { observation.marker_seen = {0, 0, 0, 1, 1, 1}; }
  SECTION("not numbers") {
    observation.marker_seen = {1, 1, 1, 0, 0, 0};
    observation.markers[1].y() = std::numeric_limits<double>::quiet_NaN();
  }
  SECTION("beyond all measure") {
    observation.marker_seen = {1, 1, 1, 0, 0, 0};
    observation.markers[1].y() = 1.7e308;
  }
  CHECK(simulator->step(observation).markers_used == 0);
  CHECK(simulator->state_hash() == before);
  CHECK(simulator->target(0).position.allFinite());
}
