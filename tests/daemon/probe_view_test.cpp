// From the tracker's pose of a probe to what a client is told about its image.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "daemon/answer_messages.hpp"
#include "daemon/frame_processor.hpp"
#include "protocol/client_messages.hpp"
#include "tests/daemon/fake_simulator.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using core::Vec3;

namespace {

constexpr std::uint64_t kMs = 1'000'000;

core::Scene probed_scene() {
  core::Scene scene = small_scene();
  scene.probes = {{"bare", {}, 0.0}, {"US", {}, 0.0}};
  return scene;
}

core::ImagePlane image_plane() {
  core::ImagePlane image;
  image.probe_T_image.rotation = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  image.probe_T_image.translation = Vec3(-19.0, 0.5, -30.0);
  image.spacing = {0.1, 0.125};
  image.size = {380, 500};
  return image;
}

struct Bench {
  config::DaemonConfig config = small_config();
  FakeSimulator simulator{probed_scene()};
  daemon::Counters counters;
  std::optional<daemon::FrameProcessor> processor;
  daemon::Answer previous, answer;

  Bench() {
    config.bundle.scene = probed_scene();
    config.bundle.probe_images = {std::nullopt, image_plane()};
    config.bundle.tissue_from_tracker.rotation = Eigen::AngleAxisd(-1.1, Vec3::UnitX()).toRotationMatrix();
    config.bundle.tissue_from_tracker.translation = Vec3(100.0, -50.0, 20.0);
    processor.emplace(simulator, config, counters);
  }
  const daemon::Answer& process(const FrameBuilder& frame) {
    previous = answer;
    processor->process(frame.frame, previous, answer);
    return answer;
  }
};

const Vec3 kPlace(12.0, -34.0, 56.0);               // mm, tracker
const std::array<double, 3> kTurn{0.3, -0.8, 2.1};  // rad, about x, y, z as turned by those before

FrameBuilder probe_frame(std::uint32_t number) {
  FrameBuilder builder(number);
  builder.stamp(number * 10 * kMs);
  builder.frame.objects.push_back({protocol::Name::from("US").value(), {kPlace.x(), kPlace.y(), kPlace.z()}, kTurn});
  return builder;
}

// 4 x 4, by elementary rotations written out.
Eigen::Matrix4d turned(int axis, double angle) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  m(a, a) = m(b, b) = std::cos(angle);
  m(a, b) = -std::sin(angle);
  m(b, a) = std::sin(angle);
  return m;
}

Eigen::Matrix4d matrix(const core::RigidTransform& t) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = t.rotation;
  m.topRightCorner<3, 1>() = t.translation;
  return m;
}

}  // namespace

TEST_CASE("targets are where homogeneous matrices put them in the image, to 0.01 mm") {
  Bench bench;
  const daemon::Answer& answer = bench.process(probe_frame(1));
  REQUIRE(answer.probes.size() == 2);
  CHECK_FALSE(answer.probes[0].seen);
  REQUIRE(answer.probes[1].seen);
  REQUIRE(answer.probes[1].targets.size() == 2);
  Eigen::Matrix4d tracker_T_probe = Eigen::Matrix4d::Identity();
  tracker_T_probe.topRightCorner<3, 1>() = kPlace;
  for (int axis = 0; axis < 3; ++axis) tracker_T_probe *= turned(axis, kTurn[static_cast<std::size_t>(axis)]);
  const Eigen::Matrix4d tracker_T_image = tracker_T_probe * matrix(image_plane().probe_T_image);
  for (std::size_t t = 0; t < 2; ++t) {
    const auto& p = answer.targets[t].position;  // tracker
    const Eigen::Vector4d at = tracker_T_image.inverse() * Eigen::Vector4d(p[0], p[1], p[2], 1.0);
    const core::ImagePoint& point = answer.probes[1].targets[t];
    CHECK(point.pixel.x() * 0.1 == Approx(at.x()).margin(1e-6));
    CHECK(point.pixel.y() * 0.125 == Approx(at.y()).margin(1e-6));
    CHECK(point.distance == Approx(at.z()).margin(1e-6));
  }
  // The force is turned to the tracker's axes.
  const Vec3 force = bench.config.bundle.tissue_from_tracker.rotation.transpose() * Vec3(4, 5, 6);
  CHECK((Vec3(answer.probes[1].force[0], answer.probes[1].force[1], answer.probes[1].force[2]) - force).norm() < 1e-12);
  CHECK(bench.counters.value(static_cast<std::size_t>(daemon::Count::unknown_names)) == 0);
}

TEST_CASE("a probe is held through a gap of a tenth of a second and then does not touch") {
  Bench bench;
  bench.process(probe_frame(1));
  for (std::uint32_t number = 2; number <= 11; ++number) {
    FrameBuilder frame(number);
    frame.stamp(number * 10 * kMs);
    const daemon::Answer& answer = bench.process(frame);
    CHECK(answer.probes[1].seen);
    CHECK((answer.reasons & protocol::kPadMissing) != 0);
  }
  FrameBuilder frame(13);
  frame.stamp(13 * 10 * kMs);
  const daemon::Answer& answer = bench.process(frame);
  CHECK_FALSE(answer.probes[1].seen);
  CHECK(answer.probes[1].targets.empty());
  CHECK(answer.probes[1].force == std::array<double, 3>{});
  CHECK_FALSE(bench.simulator.observations().back().probes[1].seen);
}

TEST_CASE("what a client is told of a probe passes its own gates") {
  Bench bench;
  bench.process(probe_frame(1));
  for (std::size_t probe = 0; probe < 2; ++probe) {
    const auto image = bench.config.bundle.probe_images[probe];
    REQUIRE(daemon::probe_view_part_count(bench.answer, probe) == 1);
    const protocol::ProbeView view =
        daemon::probe_view_part(bench.answer, image, {protocol::Validity::valid, 0, 5}, 6, probe, 0);
    CHECK(view.index == probe);
    CHECK(view.probe_count == 2);
    CHECK(view.has_image == image.has_value());
    CHECK(view.targets.size() == (probe == 1 ? 2 : 0));
    std::array<std::uint8_t, protocol::kMaxDatagram> buffer;
    const std::size_t size = protocol::encode_client_message({}, view, buffer);
    const auto decoded = protocol::decode_client_message(std::span(buffer).first(size));
    CHECK(decoded.refusal == protocol::ClientRefusal::none);
  }
}
