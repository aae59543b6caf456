// Counts what the heap is asked for, by all threads, while frames go through the daemon.
#include <catch2/catch.hpp>
#include <cstdint>

#include "tests/allocation_count.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;

TEST_CASE("After warm-up a frame asks nothing of the heap, from tracker socket to subscriber") {
  RunningDaemon daemon;
  daemon.simulator.keep_observations = false;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  client.ask<protocol::SubscribeReply>(protocol::Subscribe{
      .what = protocol::kTargets | protocol::kMesh | protocol::kStatus, .lease_s = 3600, .rate_hz = 0});
  std::uint32_t number = 0;
  const auto run = [&](std::uint32_t frames) {
    for (const std::uint32_t end = number + frames; number < end;) {
      ++number;
      FrameBuilder frame(number);
      frame.stamp(number * std::uint64_t{10'000'000});
      frame.marker("M1", core::Vec3(0, 0, 40)).pad("A1", core::Vec3(10, 13, 13)).truth("T1", core::Vec3(1, 2, 3));
      frame.marker("nobody", core::Vec3(0, 0, 0));
      tracker.send(frame.frame);
      client.await_if<protocol::MeshPositions>([&](const auto& mesh) { return mesh.tracker_frame == number; });
      client.send(protocol::QueryTargets{});
      client.await_if<protocol::Predictions>([&](const auto& p) { return p.tracker_frame == number; });
    }
  };
  run(100);
  const std::size_t before = allocation_count();
  run(300);
  CHECK(allocation_count() - before == 0);
}
