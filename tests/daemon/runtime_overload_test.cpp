// The runtime around a simulator that is too slow, or does not come to an end.
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace std::chrono_literals;
using daemon::Count;
using protocol::Predictions;
using protocol::ValidityReason;

TEST_CASE("A step that does not end is ended, the last good answer is held, and the next frame is answered again") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  client.ask<protocol::SubscribeReply>(protocol::Subscribe{});
  tracker.send(frame_with_shift(1, 2.0).frame);
  client.await_if<Predictions>([](const Predictions& p) { return p.tracker_frame == 1; });

  daemon.simulator.endless = true;
  tracker.send(frame_with_shift(2, 3.0).frame);
  const auto held =
      client.await_if<Predictions>([](const Predictions& p) { return (p.reasons & ValidityReason::kStepBraked) != 0; });
  CHECK((held.reasons & ValidityReason::kDiverged) != 0);
  CHECK(held.validity == protocol::Validity::invalid);
  CHECK(held.tracker_frame == 1);
  CHECK(held.targets[0].position[0] == 7.0);
  CHECK(daemon.count(Count::steps_braked) == 1);
  CHECK(daemon.count(Count::steps_not_finite) == 0);

  tracker.send(frame_with_shift(3, 4.0).frame);
  const auto next = client.await_if<Predictions>([](const Predictions& p) { return p.tracker_frame == 3; });
  CHECK((next.reasons & (ValidityReason::kStepBraked | ValidityReason::kDiverged)) == 0);
  CHECK(next.targets[0].position[0] == 9.0);
}

TEST_CASE("A body whose every step takes long is given the time, after a few steps that were ended") {
  RunningDaemon daemon;
  daemon.simulator.heavy_ms = 200;  // the first is ended after 80, the second after 160
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  std::uint32_t number = 0;
  CHECK(eventually([&] {
    tracker.send(frame_with_shift(++number, 2.0).frame);
    std::this_thread::sleep_for(20ms);
    return daemon.simulator.steps >= 4;
  }));
  CHECK(daemon.count(Count::steps_braked) >= 1);
  CHECK(daemon.count(Count::steps_braked) <= 4);
  CHECK(client.ask<Predictions>(protocol::QueryTargets{}).targets[0].position[0] == 7.0);
}

TEST_CASE("Steps that take longer than their frames get fewer iterations, and clients see why") {
  RunningDaemon daemon;
  daemon.simulator.delay_ms = 14;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  std::uint32_t number = 0;
  REQUIRE(eventually([&] {
    tracker.send(frame_with_shift(++number, 0.0).frame);
    std::this_thread::sleep_for(10ms);
    return (client.ask<Predictions>(protocol::QueryTargets{}).reasons & ValidityReason::kOverloaded) != 0;
  }));
  REQUIRE(eventually([&] {
    tracker.send(frame_with_shift(++number, 0.0).frame);
    std::this_thread::sleep_for(10ms);
    return daemon.simulator.observations().back().max_iterations == 3;
  }));
  CHECK(daemon.simulator.observations().front().max_iterations == 0);
}
