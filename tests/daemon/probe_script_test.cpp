#include "daemon/probe_script.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "daemon/scene_loader.hpp"
#include "daemon/simulated_tracker.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

const config::Bundle& demo() {
  static const config::Bundle bundle = config::load_bundle(TISSUED_SOURCE_DIR "/config/demo");
  return bundle;
}

ProbeScript script_of(const std::string& moves) {
  const core::Scene scene = load_scene(demo());
  return {scene, scene.probes[0].shape, demo().probe_images[0], parse_probe_script("US=" + moves).moves, 8.0, 1.0};
}

// mm, of the deepest point of the undeformed skin in the probe; negative above it.
double depth_of(const core::RigidTransform& pose) {
  const core::Scene scene = load_scene(demo());
  double nearest = 1e9;
  for (int node : core::nodes_of(*scene.mesh.find_surface("skin")))
    nearest =
        std::min(nearest, core::signed_distance(scene.probes[0].shape, pose.inverse()(scene.mesh.node(node))).distance);
  return -nearest;
}

}  // namespace

TEST_CASE("scripts are read, and what they cannot be is said") {
  const ScriptedProbe probe = parse_probe_script("US=press,slide,hold,lift");
  CHECK(probe.name == "US");
  CHECK(probe.moves == std::vector{ProbeMove::press, ProbeMove::slide, ProbeMove::hold, ProbeMove::lift});
  CHECK_THROWS_WITH(parse_probe_script("US"), "--probe US: should be NAME=press,slide,hold,lift");
  CHECK_THROWS_WITH(parse_probe_script("=press"), Catch::Contains("should be NAME="));
  CHECK_THROWS_WITH(parse_probe_script("US="), "--probe US=: no move");
  CHECK_THROWS_WITH(parse_probe_script("US=press,turn"),
                    "--probe US=press,turn: `turn` is not press, slide, hold or lift");
}

TEST_CASE("a scripted probe is above the skin, then as deep as it should be, with its image's rows into the body") {
  const ProbeScript script = script_of("press,slide,lift");
  for (const double time : {0.0, 0.9, 1.0, 4.0}) CHECK(depth_of(script.at(time)) < 0.0);
  CHECK(depth_of(script.at(2.0)) == Approx(8.0).margin(0.5));
  CHECK(depth_of(script.at(3.0)) == Approx(8.0).margin(0.5));
  const core::Vec3 rows = script.at(2.5).rotation * demo().probe_images[0]->probe_T_image.rotation.col(1);
  CHECK((rows + core::Vec3::UnitZ()).norm() < 1e-6);  // half way: straight down
  CHECK(script.at(2.0).translation.x() < script.at(3.0).translation.x());
  CHECK(script.at(6.0).translation.x() < script.at(5.0).translation.x());  // the next time it slides back
}

TEST_CASE("a scripted probe moves without jumps") {
  const ProbeScript script = script_of("press,slide,hold,lift");
  for (int k = 0; k < 1200; ++k) {
    const auto a = script.at(0.01 * k), b = script.at(0.01 * (k + 1));
    CHECK((a.translation - b.translation).norm() < 1.5);
    CHECK((a.rotation - b.rotation).norm() < 0.05);
  }
}

// Through the angles of the stream.
TEST_CASE("the simulated tracker sends the pose that it presses its tissue with") {
  TrackerSimulation simulation;
  simulation.probes = {parse_probe_script("US=press,slide,lift")};
  simulation.pattern = PushPattern::rest;
  simulation.probe_seconds = 0.5;
  core::RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.9, core::Vec3(1, 1, 3).normalized()).toRotationMatrix();
  pose.translation = core::Vec3(10, 20, 30);
  const core::Scene scene = load_scene(demo());
  SimulatedTracker tracker(scene, pose, simulation, demo().probe_images);
  const ProbeScript script(scene, scene.probes[0].shape, demo().probe_images[0], simulation.probes[0].moves, 8.0, 0.5);
  double deepest = 0.0;
  for (int frame = 0; frame < 220; ++frame) {
    const auto& sent = tracker.next();
    const auto& object = sent.objects[sent.objects.size() - 1];
    REQUIRE(object.name.view() == "US");
    core::RigidTransform seen;
    const auto& turn = object.rotation_rad;
    seen.rotation = (Eigen::AngleAxisd(turn[0], core::Vec3::UnitX()) * Eigen::AngleAxisd(turn[1], core::Vec3::UnitY()) *
                     Eigen::AngleAxisd(turn[2], core::Vec3::UnitZ()))
                        .toRotationMatrix();
    seen.translation = core::Vec3(object.position[0], object.position[1], object.position[2]);
    const core::RigidTransform tissue_T_probe = pose * seen, wanted = script.at(0.01 * frame);
    CHECK((tissue_T_probe.rotation - wanted.rotation).norm() < 1e-9);
    CHECK((tissue_T_probe.translation - wanted.translation).norm() < 1e-9);
    const auto& truth = sent.truth[0].position;
    const core::Vec3 moved = pose(core::Vec3(truth[0], truth[1], truth[2])) - scene.targets[0].rest;
    deepest = std::max(deepest, moved.norm());
  }
  CHECK(deepest > 0.5);  // the press reaches the targets
}
