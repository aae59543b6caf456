// The daemon's runtime seen from the tracker's side: real sockets, a fake simulator.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <limits>
#include <random>
#include <thread>
#include <vector>

#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace std::chrono_literals;
using core::Vec3;
using daemon::Count;
using protocol::AssemblerEvent;
using protocol::Predictions;
using protocol::Validity;
using protocol::ValidityReason;

namespace {

constexpr std::uint64_t kMs = 1'000'000;
constexpr std::uint64_t kRounding = 1000;  // ns; delays are kept in s

// All markers at rest but for M1, which moves by 0.01 mm a frame along x: the fake simulator moves T1 as much.
FrameBuilder moving_frame(std::uint32_t number) {
  FrameBuilder builder(number);
  builder.stamp(number * 10 * kMs);
  for (const auto& marker : small_scene().markers) builder.marker(marker.name, marker.rest);
  builder.frame.markers[0].position[0] += 0.01 * number;
  return builder;
}

bool is_of_frame(const Predictions& predictions, std::uint32_t number) {
  return predictions.tracker_frame == number &&
         std::abs(predictions.targets[0].position[0] - (5.0 + 0.01 * number)) < 1e-9;
}

void subscribe_to_targets(FakeClient& client) {
  client.ask<protocol::SubscribeReply>(protocol::Subscribe{.what = protocol::kTargets, .lease_s = 60, .rate_hz = 0});
}

Predictions await_frame(FakeClient& client, std::uint32_t number) {
  return client.await_if<Predictions>([number](const Predictions& p) { return p.tracker_frame == number; });
}

}  // namespace

TEST_CASE("Every frame is answered, by a prediction of that frame, at once") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  std::uint64_t quickest = std::numeric_limits<std::uint64_t>::max();  // ns, from a stamp to its frame
  for (std::uint32_t number = 1; number <= 200; ++number) {
    tracker.send(moving_frame(number).frame);
    const Predictions predictions = await_frame(client, number);
    CHECK(is_of_frame(predictions, number));
    CHECK(predictions.validity == Validity::valid);
    CHECK(predictions.stamp_ns == number * 10 * kMs);
    CHECK(predictions.send_ns >= predictions.receive_ns);
    // A machine that is busy falls behind the stamps, which are 10 ms apart: that is part of the age.
    const std::uint64_t under_way = predictions.receive_ns - predictions.stamp_ns;
    quickest = std::min(quickest, under_way);
    CHECK(predictions.age_ns >= predictions.send_ns - predictions.receive_ns);
    CHECK(predictions.age_ns <= predictions.send_ns - predictions.receive_ns + under_way - quickest + kRounding);
    CHECK(predictions.markers_seen == 4);
  }
  CHECK(daemon.count(Count::frames_stepped) == 200);
  CHECK(daemon.count(Count::frames_skipped) == 0);
}

TEST_CASE("When the step is slower than the tracker the newest frame wins and all others are counted") {
  RunningDaemon daemon;
  daemon.simulator.delay_ms = 40;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  constexpr std::uint32_t kFrames = 60;
  for (std::uint32_t number = 1; number <= kFrames; ++number) {
    tracker.send(moving_frame(number).frame);
    std::this_thread::sleep_for(4ms);
  }
  CHECK(is_of_frame(await_frame(client, kFrames), kFrames));
  CHECK(daemon.simulator.steps < 20);
  CHECK(daemon.count(Count::frames_stepped) + daemon.count(Count::frames_skipped) == kFrames);
  CHECK(daemon.count(Count::frames_stepped) == static_cast<std::uint64_t>(daemon.simulator.steps));
}

TEST_CASE("A burst that waits in the socket is taken at once, and its newest frame stepped") {
  RunningDaemon daemon;
  daemon.simulator.delay_ms = 20;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  for (std::uint32_t number = 1; number <= 100; ++number) tracker.send(moving_frame(number).frame);
  CHECK(is_of_frame(await_frame(client, 100), 100));
  CHECK(daemon.simulator.steps < 20);
  CHECK(daemon.count(Count::frames_stepped) + daemon.count(Count::frames_skipped) == 100);
}

TEST_CASE("A frame in two datagrams is joined, in either order, without its second half it is partial") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  const auto split_frame = [](std::uint32_t number) {
    auto builder = moving_frame(number);
    for (int i = 0; i < 12; ++i) builder.marker("unknown " + std::to_string(i), Vec3(0, 0, 0));
    for (int i = 0; i < 6; ++i) builder.pad("object " + std::to_string(i), Vec3(0, 0, 0));
    builder.truth("T1", Vec3(0.5 * number, 0, 0));
    return FakeTracker::packets_of(builder.frame);
  };
  const auto first = split_frame(1);
  REQUIRE(first.size() == 2);
  for (const auto& packet : first) tracker.send(packet.view());
  Predictions predictions = await_frame(client, 1);
  CHECK(predictions.reasons == 0);
  CHECK(predictions.targets[0].truth[0] == 0.5);  // of the second datagram

  const auto second = split_frame(2);
  tracker.send(second[1].view());
  tracker.send(second[0].view());
  predictions = await_frame(client, 2);
  CHECK(is_of_frame(predictions, 2));
  CHECK(predictions.targets[0].truth[0] == 1.0);

  tracker.send(split_frame(3)[0].view());
  predictions = await_frame(client, 3);
  CHECK((predictions.reasons & ValidityReason::kPartialFrame) != 0);
  CHECK(predictions.validity == Validity::degraded);
  CHECK(daemon.count(AssemblerEvent::frames_deadline) == 1);
}

TEST_CASE("Through loss, doubles and disorder predictions ascend and the books balance") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  std::mt19937 random(21);
  std::vector<std::uint32_t> order;
  for (std::uint32_t number = 1; number <= 300; ++number) {
    if (random() % 10 != 0) order.push_back(number);
    if (random() % 10 == 0) order.push_back(number);
  }
  for (std::size_t i = 0; i + 3 < order.size(); ++i) std::swap(order[i], order[i + random() % 3]);
  order.push_back(301);
  std::uint32_t newest = 0;
  bool ascending = true;
  bool right = true;
  const auto listen = [&](std::chrono::milliseconds timeout) {
    while (const auto message = client.receive(timeout)) {
      const auto* predictions = std::get_if<Predictions>(&message->message);
      if (predictions == nullptr || predictions->tracker_frame == 0) continue;
      ascending = ascending && predictions->tracker_frame >= newest;
      newest = predictions->tracker_frame;
      right = right && is_of_frame(*predictions, newest);
      if (newest == 301) return;
    }
  };
  for (const std::uint32_t number : order) {
    tracker.send(moving_frame(number).frame);
    listen(0ms);
    std::this_thread::sleep_for(500us);
  }
  listen(2000ms);
  CHECK(newest == 301);
  CHECK(ascending);
  CHECK(right);
  daemon.stop();
  CHECK(daemon.count(Count::tracker_datagrams) == order.size());
  CHECK(daemon.count(AssemblerEvent::datagrams_joined) + daemon.count(AssemblerEvent::duplicate_datagrams) +
            daemon.count(AssemblerEvent::late_datagrams) ==
        order.size());
  CHECK(daemon.count(AssemblerEvent::late_datagrams) > 10);
  CHECK(daemon.count(AssemblerEvent::duplicate_datagrams) > 10);
  CHECK(daemon.count(Count::frames_stepped) + daemon.count(Count::frames_skipped) ==
        daemon.count(AssemblerEvent::frames_all_parts));
}

TEST_CASE("When the tracker stops the answer ages, is stale, is lost, and recovers by itself") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  CHECK(client.ask<Predictions>(protocol::QueryTargets{}).validity == Validity::no_data);
  subscribe_to_targets(client);
  tracker.send(moving_frame(1).frame);
  CHECK(await_frame(client, 1).validity == Validity::valid);

  // A subscriber goes on to hear of it without asking, with the age that the clock says.
  std::uint64_t age_ns = 0;
  Predictions predictions;
  const auto await_validity = [&](Validity validity) {
    predictions = client.await_if<Predictions>([&](const Predictions& p) {
      CHECK(is_of_frame(p, 1));
      CHECK(p.age_ns > age_ns);
      age_ns = p.age_ns;
      return p.validity == validity;
    });
  };
  await_validity(Validity::degraded);
  CHECK(predictions.reasons == ValidityReason::kTrackerSilent);
  CHECK(predictions.age_ns > 100 * kMs);
  await_validity(Validity::invalid);
  CHECK(predictions.age_ns > 400 * kMs);
  const Predictions asked = client.ask<Predictions>(protocol::QueryTargets{});
  CHECK(asked.validity == Validity::invalid);
  CHECK(asked.age_ns > 400 * kMs);

  tracker.send(moving_frame(60).frame);
  predictions = await_frame(client, 60);
  CHECK(predictions.validity == Validity::valid);
  CHECK(is_of_frame(predictions, 60));
}

TEST_CASE("A tracker that starts again at frame 1 is followed") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  for (std::uint32_t number = 5000; number < 5010; ++number) {
    tracker.send(moving_frame(number).frame);
    await_frame(client, number);
  }
  for (std::uint32_t number = 1; number <= 5; ++number) {
    tracker.send(moving_frame(number).frame);
    std::this_thread::sleep_for(5ms);
  }
  CHECK(is_of_frame(await_frame(client, 5), 5));
  CHECK(daemon.count(AssemblerEvent::restarts) == 1);
  CHECK(daemon.count(Count::stamps_refused) == 0);
  daemon.stop();
  for (const auto& observation : daemon.simulator.observations()) CHECK(observation.dt <= 0.02 + 1e-9);
}

TEST_CASE("A tracker that changes its rate gets another time step") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  std::uint64_t stamp_ns = 0;
  for (std::uint32_t number = 1; number <= 400; ++number) {
    stamp_ns += number < 100 ? 10 * kMs : 4 * kMs;  // 100 Hz, then 250 Hz
    tracker.send(moving_frame(number).stamp(stamp_ns).frame);
    await_frame(client, number);
  }
  CHECK(daemon.simulator.time_step() == Approx(0.004));
  CHECK(daemon.count(Count::rate_changes) == 1);
}

TEST_CASE("Garbage of every length is refused, counted by reason, and survived") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  std::mt19937 random(1);
  const auto good = FakeTracker::packets_of(moving_frame(1).frame).at(0);
  std::vector<std::uint8_t> bytes;
  std::uint64_t sent = 0;
  for (std::size_t length = 0; length <= 1200; ++length) {
    bytes.resize(length);
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::uint8_t>(random() | 1u); });
    tracker.send(bytes);
    ++sent;
    if (length < good.size) {
      tracker.send(good.view().first(length));
      ++sent;
    }
    if (length % 64 == 0) std::this_thread::sleep_for(2ms);  // the socket's buffer is not what is tested
  }
  REQUIRE(eventually([&] { return daemon.count(Count::tracker_datagrams) == sent; }));
  std::uint64_t judged = 0;
  for (std::size_t i = 0; i < protocol::kTrackerRefusalCount; ++i) {
    judged += daemon.count(static_cast<protocol::TrackerRefusal>(i));
  }
  CHECK(judged == sent);
  CHECK(daemon.count(protocol::TrackerRefusal::too_short) == 10);
  CHECK(daemon.count(protocol::TrackerRefusal::too_long) == 176);
  CHECK(daemon.count(protocol::TrackerRefusal::none) <= 2);  // five bytes that announce no item are a frame
  tracker.send(moving_frame(2).frame);
  const Predictions predictions = client.await_if<Predictions>([](const Predictions& p) { return is_of_frame(p, 2); });
  CHECK(predictions.validity == Validity::valid);
}

TEST_CASE("Labels may carry the subject, markers may come as plain Vicon objects, strangers are counted") {
  auto config = small_config();
  config.tracker.subject = "phantom";
  RunningDaemon daemon(config);
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  subscribe_to_targets(client);
  FrameBuilder frame(1);
  for (const auto& marker : small_scene().markers) frame.pad("phantom:" + marker.name, marker.rest);
  frame.frame.objects[0].position[0] += 0.01;
  frame.pad("phantom:A1", Vec3(12, 13, 13)).pad("wand", Vec3(0, 0, 0));
  tracker.send(frame.frame);
  const Predictions predictions = await_frame(client, 1);
  CHECK(is_of_frame(predictions, 1));
  CHECK(predictions.reasons == 0);
  CHECK_FALSE(predictions.has_stamp);
  REQUIRE(predictions.pads.size() == 1);
  CHECK(predictions.pads[0].force == std::array<double, 3>{1, 2, 3});
  CHECK(daemon.count(Count::unknown_names) == 1);
  CHECK(daemon.count(AssemblerEvent::frames_all_names) == 1);
}
