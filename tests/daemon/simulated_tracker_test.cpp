#include "daemon/simulated_tracker.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "daemon/scene_loader.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

core::Scene demo_scene() { return load_scene(config::load_bundle(TISSUED_SOURCE_DIR "/config/demo")); }

core::Vec3 vector(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

bool same(const protocol::TrackerFrame& a, const protocol::TrackerFrame& b) {
  const auto equal = [](const auto& x, const auto& y, const auto& equal_entry) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(), equal_entry);
  };
  return a.frame_number == b.frame_number && a.stamp_ns == b.stamp_ns &&
         equal(a.objects, b.objects, [](const auto& x, const auto& y) { return x.position == y.position; }) &&
         equal(a.markers, b.markers,
               [](const auto& x, const auto& y) { return x.position == y.position && x.occluded == y.occluded; }) &&
         equal(a.truth, b.truth, [](const auto& x, const auto& y) { return x.position == y.position; });
}

}  // namespace

TEST_CASE("Equal seeds give equal frames, bit for bit") {
  const core::Scene scene = demo_scene();
  TrackerSimulation simulation;
  simulation.dropout = 0.2;
  SimulatedTracker a(scene, {}, simulation), b(scene, {}, simulation);
  simulation.seed = 2;
  SimulatedTracker c(scene, {}, simulation);
  bool differs = false;
  for (int i = 0; i < 130; ++i) {
    const protocol::TrackerFrame frame = a.next();
    REQUIRE(same(frame, b.next()));
    differs |= !same(frame, c.next());
  }
  CHECK(differs);
}

TEST_CASE("Frames are numbered from 1 and stamped at the tracker's rate") {
  TrackerSimulation simulation;
  simulation.rate_hz = 250;
  SimulatedTracker tracker(demo_scene(), {}, simulation);
  const std::uint64_t first = tracker.next().stamp_ns.value();
  for (std::uint32_t number = 2; number < 20; ++number) {
    const auto& frame = tracker.next();
    CHECK(frame.frame_number == number);
    CHECK(frame.stamp_ns == first + (number - 1) * 4'000'000ull);
  }
}

TEST_CASE("At rest, markers are off their places by placement and noise, targets by nothing") {
  const core::Scene scene = demo_scene();
  TrackerSimulation simulation;
  simulation.pattern = PushPattern::rest;
  simulation.placement_error = 0.5;
  simulation.noise = 0.1;
  SimulatedTracker tracker(scene, {}, simulation);
  const int frames = 200;
  std::vector<core::Vec3> sum(scene.markers.size(), core::Vec3::Zero());
  std::vector<double> square_sum(scene.markers.size(), 0.0);
  for (int f = 0; f < frames; ++f) {
    const auto& frame = tracker.next();
    for (std::size_t m = 0; m < sum.size(); ++m) {
      sum[m] += vector(frame.markers[m].position);
      square_sum[m] += vector(frame.markers[m].position).squaredNorm();
    }
    for (std::size_t t = 0; t < scene.targets.size(); ++t) {
      REQUIRE((vector(frame.truth[t].position) - scene.targets[t].rest).norm() < 1e-6);
    }
  }
  double variance = 0.0, misplaced = 0.0;
  for (std::size_t m = 0; m < sum.size(); ++m) {
    const core::Vec3 mean = sum[m] / frames;
    variance += square_sum[m] / frames - mean.squaredNorm();
    misplaced += (mean - scene.markers[m].rest).squaredNorm();
  }
  const double markers = double(sum.size());
  CHECK(std::sqrt(variance / (3.0 * markers)) == Approx(0.1).epsilon(0.05));
  // On the skin there are two directions to be wrong in; the third is projected away.
  const double expected = 0.5 * std::sqrt(2.0);
  CHECK(std::sqrt(misplaced / markers) > 0.6 * expected);
  CHECK(std::sqrt(misplaced / markers) < 1.4 * expected);
}

TEST_CASE("Dropouts have the share asked for and come in gaps") {
  TrackerSimulation simulation;
  simulation.pattern = PushPattern::rest;
  simulation.dropout = 0.2;
  simulation.iterations = 1;
  SimulatedTracker tracker(demo_scene(), {}, simulation);
  int hidden = 0, samples = 0, gaps = 0;
  std::vector<bool> was(tracker.next().markers.size(), false);
  for (int f = 0; f < 1500; ++f) {
    const auto& frame = tracker.next();
    for (std::size_t m = 0; m < was.size(); ++m) {
      hidden += frame.markers[m].occluded ? 1 : 0;
      gaps += frame.markers[m].occluded && !was[m] ? 1 : 0;
      was[m] = frame.markers[m].occluded;
      ++samples;
    }
  }
  CHECK(hidden / double(samples) == Approx(0.2).margin(0.03));
  CHECK(hidden / double(gaps) == Approx(10.0).epsilon(0.15));  // frames: 0.1 s at 100 Hz
}

TEST_CASE("A push moves its pad along its direction and the targets with it") {
  const core::Scene scene = demo_scene();
  TrackerSimulation simulation;
  simulation.push = 8.0;
  simulation.period = 1.0;
  SimulatedTracker tracker(scene, {}, simulation);
  double most = 0.0, moved = 0.0;
  for (int f = 0; f < 150; ++f) {
    const auto& frame = tracker.next();
    const core::Vec3 push = vector(frame.objects[0].position) - scene.pads[0].center;
    CHECK((push - push.dot(scene.pads[0].direction) * scene.pads[0].direction).norm() < 1e-9);
    most = std::max(most, push.norm());
    for (std::size_t t = 0; t < scene.targets.size(); ++t) {
      moved = std::max(moved, (vector(frame.truth[t].position) - scene.targets[t].rest).norm());
    }
  }
  CHECK(most == Approx(8.0));
  CHECK(moved > 0.5);
  CHECK(moved < 8.0);
}

TEST_CASE("Frames are in the tracker's coordinates") {
  const core::Scene scene = demo_scene();
  core::RigidTransform tissue_from_tracker;
  tissue_from_tracker.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  tissue_from_tracker.translation = core::Vec3(100, 20, -5);
  TrackerSimulation simulation;
  simulation.pattern = PushPattern::rest;
  SimulatedTracker here(scene, {}, simulation), there(scene, tissue_from_tracker, simulation);
  const protocol::TrackerFrame a = here.next();
  const protocol::TrackerFrame b = there.next();
  for (std::size_t m = 0; m < a.markers.size(); ++m) {
    CHECK((tissue_from_tracker(vector(b.markers[m].position)) - vector(a.markers[m].position)).norm() < 1e-9);
  }
  CHECK((tissue_from_tracker(vector(b.objects[0].position)) - scene.pads[0].center).norm() < 1e-9);
}
