#include "daemon/frame_processor.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>

#include "daemon/validity.hpp"
#include "protocol/prediction_messages.hpp"
#include "tests/daemon/fake_simulator.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using core::Vec3;
using daemon::Answer;
using daemon::Count;
using daemon::FrameProcessor;
using protocol::ValidityReason;
using Kind = core::PadInput::Kind;

namespace {

constexpr std::uint64_t kMs = 1'000'000;

struct Bench {
  config::DaemonConfig config = small_config();
  FakeSimulator simulator{small_scene()};
  daemon::Counters counters;
  std::optional<FrameProcessor> processor;
  Answer previous, answer;

  void build() { processor.emplace(simulator, config, counters); }

  const Answer& process(const FrameBuilder& frame) {
    if (!processor) build();
    previous = answer;
    processor->process(frame.frame, previous, answer);
    return answer;
  }
  core::Observation last() const { return simulator.observations().back(); }
};

// All four markers of the small scene at their rest places, moved by `t`.
FrameBuilder rest_frame(std::uint32_t number, const core::RigidTransform& t = {}) {
  FrameBuilder builder(number);
  builder.stamp(number * 10 * kMs);
  for (const auto& marker : small_scene().markers) builder.marker(marker.name, t(marker.rest));
  return builder;
}

Vec3 vec(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

TEST_CASE("Before any frame the answer is the rest shape, and says that there is no frame") {
  Bench bench;
  bench.build();
  bench.processor->rest_answer(bench.answer);
  CHECK_FALSE(bench.answer.has_frame);
  REQUIRE(bench.answer.targets.size() == 2);
  CHECK(vec(bench.answer.targets[0].position) == Vec3(5, 5, 5));
  CHECK(bench.answer.pads.empty());
}

TEST_CASE("Names find their markers, pads and targets, what the scene does not have is counted") {
  Bench bench;
  bench.config.unused_markers = {"M9"};
  const Answer& answer = bench.process(FrameBuilder(7)
                                           .stamp(42)
                                           .received(1234)
                                           .marker("M3", Vec3(1, 41, 0))
                                           .marker("M1", Vec3(0, 2, 40))
                                           .marker("M2", Vec3(40, 0, 0), true)
                                           .marker("M9", Vec3(0, 0, 0))
                                           .marker("X1", Vec3(0, 0, 0))
                                           .marker("A1", Vec3(0, 0, 0))
                                           .pad("A1", Vec3(11, 13, 13))
                                           .pad("probe", Vec3(0, 0, 0))
                                           .force("A7", Vec3(1, 0, 0))
                                           .truth("T2", Vec3(7, 7, 7))
                                           .truth("T9", Vec3(7, 7, 7)));
  const auto observation = bench.last();
  CHECK(observation.marker_seen == std::vector<std::uint8_t>{1, 0, 1, 0});
  CHECK(observation.markers[2] == Vec3(1, 41, 0));
  CHECK(observation.pads[0].kind == Kind::pose);
  CHECK(observation.pads[0].center == Vec3(11, 13, 13));
  CHECK(bench.counters[Count::unknown_names] == 5);
  CHECK(answer.has_frame);
  CHECK(answer.tracker_frame == 7);
  CHECK(answer.stamp_ns == 42u);
  CHECK(answer.receive_ns == 1234);
  CHECK(answer.markers_seen == 2);
  REQUIRE(answer.targets.size() == 2);
  CHECK(vec(answer.targets[0].position) == Vec3(5, 7, 5));
  CHECK(answer.targets[0].covariance == std::array<double, 6>{1, 0, 0, 4, 0, 9});
  CHECK_FALSE(answer.targets[0].truth.has_value());
  CHECK(vec(answer.targets[1].truth.value()) == Vec3(7, 7, 7));
  REQUIRE(answer.pads.size() == 1);
  CHECK(vec(answer.pads[0].force) == Vec3(1, 2, 3));
}

TEST_CASE("A known pose of the tracker turns what comes in, and what goes out back again") {
  Bench bench;
  core::RigidTransform& t = bench.config.bundle.tissue_from_tracker;
  t.rotation = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()).toRotationMatrix();
  t.translation = Vec3(100, 0, 0);
  const core::RigidTransform tracker_from_tissue = t.inverse();
  auto frame = rest_frame(1, tracker_from_tissue);
  frame.pad("A1", tracker_from_tissue(Vec3(13, 13, 13)));
  const Answer& answer = bench.process(frame);
  CHECK(bench.last().markers[1].isApprox(Vec3(40, 0, 0), 1e-12));
  CHECK(bench.last().pads[0].center.isApprox(Vec3(13, 13, 13), 1e-12));
  CHECK(vec(answer.targets[0].position).isApprox(tracker_from_tissue(Vec3(5, 5, 5)), 1e-12));
  // A quarter turn swaps the variances of x and y, and turns forces.
  CHECK(answer.targets[0].covariance[0] == Approx(4));
  CHECK(answer.targets[0].covariance[3] == Approx(1));
  CHECK(vec(answer.pads[0].force).isApprox(Vec3(2, -1, 3), 1e-12));

  daemon::MeshSnapshot mesh(4);
  bench.processor->snapshot(answer, mesh);
  CHECK(vec(mesh.positions[1]).isApprox(tracker_from_tissue(Vec3(40, 0, 0)), 1e-12));
  CHECK(mesh.tracker_frame == 1);
}

TEST_CASE("A fitted registration is found from markers at rest, before there is one nothing is fed") {
  Bench bench;
  bench.config.registration.fit = true;
  core::RigidTransform tracker_from_tissue;
  tracker_from_tissue.rotation = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  tracker_from_tissue.translation = Vec3(300, -200, 1500);

  // Two markers do not fix six degrees of freedom.
  FrameBuilder two(1);
  two.marker("M1", tracker_from_tissue(Vec3(0, 0, 40))).marker("M2", tracker_from_tissue(Vec3(40, 0, 0)));
  two.pad("A1", tracker_from_tissue(Vec3(13, 13, 13)));
  CHECK((bench.process(two).reasons & ValidityReason::kNotRegistered) != 0);
  CHECK(bench.last().marker_seen == std::vector<std::uint8_t>{0, 0, 0, 0});
  CHECK(bench.last().pads[0].kind == Kind::absent);

  auto all = rest_frame(2, tracker_from_tissue);
  all.pad("A1", tracker_from_tissue(Vec3(13, 13, 13)));
  const Answer& answer = bench.process(all);
  CHECK((answer.reasons & ValidityReason::kNotRegistered) == 0);
  CHECK(bench.last().marker_seen == std::vector<std::uint8_t>{1, 1, 1, 1});
  CHECK(bench.last().markers[0].isApprox(Vec3(0, 0, 40), 1e-9));
  CHECK(bench.last().pads[0].center.isApprox(Vec3(13, 13, 13), 1e-9));
  CHECK(vec(answer.targets[0].position).isApprox(tracker_from_tissue(Vec3(5, 5, 5)), 1e-9));
}

TEST_CASE("A stream that begins while a pad pushes is not taken for rest") {
  Bench bench;
  bench.config.registration.fit = true;
  auto pushed = rest_frame(1);
  pushed.pad("A1", Vec3(5, 13, 13));
  CHECK((bench.process(pushed).reasons & ValidityReason::kNotRegistered) != 0);
  auto released = rest_frame(2);
  released.pad("A1", Vec3(13, 13, 13));
  bench.process(released);
  CHECK((bench.answer.reasons & ValidityReason::kNotRegistered) != 0);  // it creeps back for a second
  for (std::uint32_t number = 3; number < 110; ++number) {
    auto rest = rest_frame(number);
    rest.pad("A1", Vec3(13, 13, 13));
    bench.process(rest);
  }
  CHECK((bench.answer.reasons & ValidityReason::kNotRegistered) == 0);
}

TEST_CASE("Placement offsets are learnt at rest and taken off, noise averaged away") {
  Bench bench;
  bench.config.registration.placement_sd = 0.5;
  const Vec3 offset(0.4, -0.3, 0.6);
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0.0, 0.1);
  for (std::uint32_t number = 1; number <= 50; ++number) {
    FrameBuilder frame(number);
    frame.stamp(number * 10 * kMs);
    frame.marker("M1", Vec3(0, 0, 40) + offset + Vec3(noise(random), noise(random), noise(random)));
    bench.process(frame);
  }
  CHECK(bench.counters[Count::rest_frames] == 50);
  CHECK(bench.counters[Count::registration_rms_um] == Approx(1e3 * offset.norm()).margin(50));
  // The pad pushes: what is seen now is motion, not offset.
  for (std::uint32_t number = 51; number <= 60; ++number) {
    FrameBuilder frame(number);
    frame.stamp(number * 10 * kMs).pad("A1", Vec3(10, 13, 13)).marker("M1", Vec3(-5, 0, 40) + offset);
    bench.process(frame);
    CHECK((bench.last().markers[0] - Vec3(-5, 0, 40)).norm() < 0.06);
  }
}

TEST_CASE("A marker that first appears when the others are calibrated waits until the tissue is at rest again") {
  Bench bench;
  bench.config.registration.rest_frames = 3;
  const auto frame_with = [](std::uint32_t number, double pad_x, bool late_marker) {
    FrameBuilder frame(number);
    frame.stamp(number * 10 * kMs).marker("M1", Vec3(0, 0, 40)).pad("A1", Vec3(pad_x, 13, 13));
    if (late_marker) frame.marker("M2", Vec3(40, 0, 0));
    return frame;
  };
  std::uint32_t number = 1;
  for (; number <= 5; ++number) bench.process(frame_with(number, 13, false));
  for (; number <= 10; ++number) bench.process(frame_with(number, 8, true));
  CHECK(bench.last().marker_seen == std::vector<std::uint8_t>{1, 0, 0, 0});
  CHECK(bench.counters[Count::late_markers] == 5);
  for (; number <= 120; ++number) bench.process(frame_with(number, 13, true));
  CHECK(bench.last().marker_seen == std::vector<std::uint8_t>{1, 1, 0, 0});
}

TEST_CASE("Late markers are used where a frame has none of its own, and say how old they are") {
  Bench bench;
  const auto with_late = [](std::uint32_t number, std::uint32_t late, bool stamped) {
    FrameBuilder builder(number);
    if (stamped) builder.stamp(number * 10 * kMs);
    builder.frame.late.frame_number = late;
    if (stamped) builder.frame.late.stamp_ns = late * 10 * kMs + 3 * kMs;
    builder.frame.late.markers.push_back({name_of("M1"), {-1, 0, 40}, false});
    return builder;
  };
  bench.process(rest_frame(1));
  CHECK(bench.last().marker_age == 0.0);
  bench.process(with_late(12, 4, true));
  CHECK(bench.last().marker_age == Approx(0.077));
  CHECK(bench.last().marker_seen == std::vector<std::uint8_t>{1, 0, 0, 0});
  bench.process(with_late(13, 5, false));
  CHECK(bench.last().marker_age == Approx(0.08));
  CHECK(bench.counters[Count::delayed_markers] == 2);
  bench.simulator.too_late = 1;
  bench.process(with_late(14, 6, true));
  CHECK(bench.counters[Count::delayed_markers] == 2);
  CHECK(bench.counters[Count::markers_too_late] == 1);
  bench.simulator.too_late = 0;
  // Markers of its own are newer.
  bench.process(with_late(15, 7, true).marker("M2", Vec3(40, 0, 0)));
  CHECK(bench.last().marker_age == 0.0);
  CHECK(bench.last().marker_seen == std::vector<std::uint8_t>{0, 1, 0, 0});
}

TEST_CASE("A force beside a pad's pose is a measurement, in tissue coordinates") {
  Bench bench;
  bench.config.bundle.tissue_from_tracker.rotation =
      Eigen::AngleAxisd(1.5707963267948966, Vec3::UnitZ()).toRotationMatrix();
  bench.process(FrameBuilder(1).stamp(10 * kMs).pad("A1", Vec3(13, -13, 13)).force("A1", Vec3(2, 0, 1)));
  REQUIRE(bench.last().pads[0].kind == Kind::pose);
  REQUIRE(bench.last().pads[0].measured_force);
  CHECK((*bench.last().pads[0].measured_force - Vec3(0, 2, 1)).norm() < 1e-12);
  bench.process(FrameBuilder(2).stamp(20 * kMs).pad("A1", Vec3(13, -13, 13)));
  CHECK_FALSE(bench.last().pads[0].measured_force);
}

TEST_CASE("A step says why its answer is to be used with care") {
  Bench bench;
  const auto reasons_after = [&](FrameBuilder frame) { return bench.process(frame).reasons; };
  CHECK(reasons_after(rest_frame(1)) == 0);
  bench.simulator.converged = false;
  CHECK(reasons_after(rest_frame(2)) == ValidityReason::kNotConverged);
  bench.simulator.converged = true;
  bench.simulator.rejected = 1;
  CHECK(reasons_after(rest_frame(3)) == ValidityReason::kMarkersRejected);
  bench.simulator.rejected = 0;
  CHECK(reasons_after(FrameBuilder(4).stamp(40 * kMs)) == ValidityReason::kNoMarkers);
  bench.simulator.rejected = 2;
  CHECK(reasons_after(rest_frame(4)) == (ValidityReason::kMarkersRejected | ValidityReason::kFewMarkers));
  bench.simulator.rejected = 0;
  bench.simulator.pad_ramp = 0.2;
  CHECK(reasons_after(rest_frame(4)) == ValidityReason::kNotConverged);
  bench.simulator.pad_ramp = 0.05;
  CHECK(reasons_after(rest_frame(4)) == 0);
  CHECK(reasons_after(rest_frame(5).completion(protocol::FrameCompletion::superseded)) ==
        ValidityReason::kPartialFrame);
  bench.simulator.delay_ms = 12;
  CHECK(reasons_after(rest_frame(6)) == ValidityReason::kDeadlineMissed);
  bench.simulator.delay_ms = 0;
  CHECK(reasons_after(rest_frame(7).pad("A1", Vec3(12, 13, 13))) == 0);
  CHECK(reasons_after(rest_frame(8)) == ValidityReason::kPadMissing);
  CHECK(bench.counters[Count::pads_held] == 1);
  // Nobody has seen it leave the skin.
  bench.simulator.delay_ms = 0;
  for (std::uint32_t number = 9; number < 40; ++number)
    CHECK(reasons_after(rest_frame(number)) == ValidityReason::kPadMissing);
  CHECK(reasons_after(rest_frame(40).pad("A1", Vec3(13, 13, 13))) == 0);
  for (std::uint32_t number = 41; number < 60; ++number) reasons_after(rest_frame(number));
  CHECK(reasons_after(rest_frame(60)) == 0);
}

TEST_CASE("A frame that was long under way is as old as it is") {
  Bench bench;
  CHECK(bench.process(rest_frame(1)).delay_ns == 0);
  FrameBuilder late = rest_frame(2);
  late.received(late.frame.receive_ns + 300 * kMs);
  const Answer& answer = bench.process(late);
  CHECK(1e-6 * static_cast<double>(answer.delay_ns) == Approx(300.0).margin(1.0));
  const daemon::Verdict verdict = daemon::judge(answer, answer.receive_ns, bench.config.staleness);
  CHECK(verdict.age_ns == answer.delay_ns);
  CHECK((verdict.reasons & ValidityReason::kTrackerSilent) != 0);
}

TEST_CASE("Plain Vicon frames, which do not say how many datagrams they have, are not called partial") {
  Bench bench;
  FrameBuilder frame(1);
  frame.marker("M1", Vec3(0, 0, 40)).marker("M2", Vec3(40, 0, 0)).marker("M3", Vec3(0, 40, 0));
  frame.completion(protocol::FrameCompletion::deadline);
  CHECK(bench.process(frame).reasons == 0);
}

TEST_CASE("A simulator that is open loop by choice does not miss markers") {
  Bench bench;
  bench.config.simulator.kind = "admm";
  bench.simulator.rejected = 4;  // none used
  CHECK(bench.process(rest_frame(1)).reasons == 0);
}

TEST_CASE("A step that is not finite holds the last good answer") {
  Bench bench;
  bench.process(rest_frame(1));
  const auto poison = GENERATE(0, 1);
  (poison == 0 ? bench.simulator.finite : bench.simulator.poison_target) = poison != 0;
  const Answer& held = bench.process(rest_frame(2));
  CHECK((held.reasons & ValidityReason::kDiverged) != 0);
  CHECK(held.tracker_frame == 1);
  CHECK(held.receive_ns == rest_frame(1).frame.receive_ns);
  CHECK(vec(held.targets[0].position) == Vec3(5, 5, 5));
  CHECK(bench.counters[Count::steps_not_finite] == 1);
  bench.simulator.finite = true;
  bench.simulator.poison_target = false;
  CHECK(bench.process(rest_frame(3)).reasons == 0);
  CHECK(bench.answer.tracker_frame == 3);
}

TEST_CASE("A simulation lost in space is brought back to rest, and its answer is not given") {
  Bench bench;
  bench.process(rest_frame(1));
  FrameBuilder lost(2);
  lost.stamp(20 * kMs).marker("M1", Vec3(1e5, 0, 40));
  const Answer& held = bench.process(lost);
  CHECK((held.reasons & ValidityReason::kDiverged) != 0);
  CHECK(held.tracker_frame == 1);
  CHECK(bench.simulator.resets == 1);
  CHECK(bench.counters[Count::steps_not_finite] == 1);
  // The body at rest is not that of the answer.
  daemon::MeshSnapshot mesh(4);
  CHECK_FALSE(bench.processor->snapshot(bench.answer, mesh));
  CHECK(bench.process(rest_frame(3)).reasons == 0);
}

TEST_CASE("A tracker that changed its rate gets another time step, a refusal is counted and survived") {
  Bench bench;
  const bool refused = GENERATE(false, true);
  bench.simulator.refuse_time_step = refused;
  for (std::uint32_t number = 1; number <= 80; ++number) {
    FrameBuilder frame(number);
    bench.process(frame.stamp(number * 20 * kMs).marker("M1", Vec3(0, 0, 40)));
  }
  CHECK(bench.simulator.time_step() == Approx(refused ? 0.01 : 0.02));
  CHECK(bench.counters[Count::rate_changes] == (refused ? 0 : 1));
  CHECK(bench.counters[Count::rate_changes_failed] == (refused ? 1 : 0));
  CHECK(bench.last().dt == Approx(0.02));
}

TEST_CASE("A long gap is clamped and counted, a clock that runs back is, too") {
  Bench bench;
  bench.process(rest_frame(1));
  bench.process(rest_frame(2).stamp(9000 * kMs));
  CHECK(bench.last().dt == Approx(0.2));
  CHECK(bench.counters[Count::dt_clamped] == 1);
  bench.process(rest_frame(3).stamp(10 * kMs));
  CHECK(bench.last().dt == Approx(0.01));
  CHECK(bench.counters[Count::stamps_refused] == 1);
}

TEST_CASE("A scene that no frame can carry, or with a name for two things, is refused at start") {
  core::Scene scene = small_scene();
  std::string reason;
  SECTION("too many markers") {
    for (int i = 0; i < 130; ++i) scene.markers.push_back({std::to_string(i), Vec3::Zero()});
    reason = "134 markers";
  }
  SECTION("too many targets") {
    for (int i = 0; i < 64; ++i) scene.targets.push_back({std::to_string(i), Vec3::Zero()});
    reason = "66 targets";
  }
  SECTION("a marker named as a pad") {
    scene.markers.push_back({"A1", Vec3::Zero()});
    reason = "'A1'";
  }
  SECTION("a name that is too long") {
    scene.markers.push_back({"a marker with a name of 30 char", Vec3::Zero()});
    reason = "24 printable";
  }
  FakeSimulator simulator(scene);
  daemon::Counters counters;
  CHECK_THROWS_WITH(FrameProcessor(simulator, small_config(), counters), Catch::Matchers::Contains(reason));
}
