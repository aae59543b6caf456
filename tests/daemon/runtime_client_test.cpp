// The daemon's runtime seen from the clients' side: real sockets, a fake simulator.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "daemon/bound_socket.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace std::chrono_literals;
using core::Vec3;
using daemon::Count;
using protocol::MeshPositions;
using protocol::Precision;
using protocol::Predictions;
using protocol::Subscribe;
using protocol::SubscribeReply;
using protocol::Validity;

namespace {

std::map<std::string, std::uint64_t> read_counters(FakeClient& client) {
  std::vector<std::string> names;
  const std::uint32_t sequence = client.send(protocol::QueryNames{protocol::NameKind::counter});
  std::size_t total = 1;
  while (names.size() < total) {
    const auto part = client.await<protocol::Names>();
    CHECK(client.header.envelope.in_reply_to == sequence);
    CHECK(part.first == names.size());
    total = part.total;
    for (const auto& name : part.names) names.emplace_back(name.view());
  }
  std::map<std::string, std::uint64_t> counters;
  const auto status = client.ask<protocol::Status>(protocol::QueryStatus{});
  REQUIRE(status.part_count == 1);
  for (const auto& counter : status.counters) counters[names.at(counter.index)] = counter.value;
  CHECK(counters.size() == names.size());
  return counters;
}

}  // namespace

TEST_CASE("Hello tells what the daemon simulates, names tell in which order") {
  RunningDaemon daemon;
  FakeClient client(daemon.runtime.client_port());
  const auto hello = client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")});
  CHECK(hello.model.view() == "small");
  CHECK(hello.simulator.view() == "kf-admm");
  CHECK(hello.nominal_rate_hz == 100.0);
  CHECK(hello.node_count == 4);
  CHECK(hello.tetrahedron_count == 1);
  CHECK(hello.triangle_count == 3);
  CHECK(hello.target_count == 2);
  CHECK(hello.marker_count == 4);
  CHECK(hello.pad_count == 1);
  const auto names = client.ask<protocol::Names>(protocol::QueryNames{protocol::NameKind::marker});
  REQUIRE(names.names.size() == 4);
  CHECK(names.names[2].view() == "M3");
  CHECK(client.ask<protocol::Names>(protocol::QueryNames{protocol::NameKind::pad}).names[0].view() == "A1");
}

TEST_CASE("Before the tracker has spoken the targets are at rest, and the answer says that there is no data") {
  RunningDaemon daemon;
  FakeClient client(daemon.runtime.client_port());
  const auto predictions = client.ask<Predictions>(protocol::QueryTargets{});
  CHECK(predictions.validity == Validity::no_data);
  REQUIRE(predictions.targets.size() == 2);
  CHECK(predictions.targets[1].position == std::array<double, 3>{8, 4, 2});
  CHECK(predictions.age_ns == 0);
  // A subscriber hears the same, unasked.
  client.ask<SubscribeReply>(Subscribe{.what = protocol::kTargets, .lease_s = 60, .rate_hz = 0});
  CHECK(client.await<Predictions>().validity == Validity::no_data);
  CHECK(client.await<Predictions>(1s).validity == Validity::no_data);
}

TEST_CASE("More targets than a datagram holds come in parts") {
  core::Scene scene = small_scene();
  for (int i = 3; i <= 25; ++i) scene.targets.push_back({std::to_string(i), Vec3(i, 0, 0)});
  RunningDaemon daemon(small_config(), scene);
  FakeClient client(daemon.runtime.client_port());
  client.send(protocol::QueryTargets{});
  std::vector<double> x;
  for (std::uint8_t part = 0; part < 3; ++part) {
    const auto predictions = client.await<Predictions>();
    CHECK(predictions.part == part);
    CHECK(predictions.part_count == 3);
    for (const auto& target : predictions.targets) {
      CHECK(target.index == x.size());
      x.push_back(target.position[0]);
    }
  }
  REQUIRE(x.size() == 25);
  CHECK(x[24] == 25.0);
}

TEST_CASE("A subscription to mesh and status brings both, the mesh of every frame") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  const auto granted = client.ask<SubscribeReply>(Subscribe{
      .what = protocol::kMesh | protocol::kStatus, .precision = Precision::float64, .lease_s = 60, .rate_hz = 0});
  CHECK(granted.what == (protocol::kMesh | protocol::kStatus));
  CHECK(granted.precision == Precision::float64);
  for (std::uint32_t number = 1; number <= 20; ++number) {
    tracker.send(frame_with_shift(number, 0.1 * number).frame);
    const auto mesh = client.await_if<MeshPositions>([&](const auto& m) { return m.tracker_frame == number; });
    CHECK(mesh.positions[1][0] == Approx(40 + 0.1 * number));
  }
  const auto status = client.await_if<protocol::Status>([](const auto& s) { return s.tracker_rate_hz >= 20; });
  CHECK(status.subscribers == 1);
  CHECK(status.step_rate_hz >= 20);
  CHECK(status.step_p50_ns > 0);
  CHECK(status.uptime_ns > 0);
}

TEST_CASE("64 subscribers all get every frame, there is no room for a 65th until one leaves") {
  auto config = small_config();
  config.clients.max_subscribers = 64;
  RunningDaemon daemon(config);
  FakeTracker tracker(daemon.runtime.tracker_port());
  std::vector<std::unique_ptr<FakeClient>> clients;
  for (int i = 0; i < 65; ++i) clients.push_back(std::make_unique<FakeClient>(daemon.runtime.client_port()));
  const Subscribe request{.what = protocol::kTargets, .lease_s = 60, .rate_hz = 0};
  for (int i = 0; i < 64; ++i) CHECK(clients[i]->ask<SubscribeReply>(request).lease_s > 0);
  CHECK(clients[64]->ask<protocol::Error>(request).reason == protocol::ErrorReason::too_many_clients);
  CHECK(daemon.count(Count::clients_refused) == 1);
  for (std::uint32_t number = 1; number <= 30; ++number) {
    tracker.send(frame_with_shift(number, number).frame);
    for (int i = 0; i < 64; ++i) {
      const auto predictions = clients[i]->await_if<Predictions>([](const auto& p) { return p.tracker_frame > 0; });
      CHECK(predictions.tracker_frame == number);
      CHECK(predictions.targets[0].position[0] == 5.0 + number);
    }
  }
  CHECK(clients[3]->ask<SubscribeReply>(protocol::Unsubscribe{}).lease_s == 0);
  CHECK(clients[64]->ask<SubscribeReply>(request).lease_s > 0);
  clients[3]->discard();
  tracker.send(frame_with_shift(31, 31).frame);
  CHECK(clients[64]->await_if<Predictions>([](const auto& p) { return p.tracker_frame == 31; }).part == 0);
  CHECK_FALSE(clients[3]->receive(50ms).has_value());
  CHECK(daemon.count(Count::sends_failed) == 0);
}

TEST_CASE("A lease that nobody renews ends, one that is renewed goes on") {
  auto config = small_config();
  config.clients.lease = 300ms;
  RunningDaemon daemon(config);
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient renewing(daemon.runtime.client_port());
  FakeClient silent(daemon.runtime.client_port());
  const Subscribe request{.what = protocol::kTargets, .lease_s = 3600, .rate_hz = 0};
  CHECK(silent.ask<SubscribeReply>(request).lease_s == 1);  // whole seconds, and never 0
  for (std::uint32_t number = 1; number <= 20; ++number) {
    renewing.ask<SubscribeReply>(request);
    tracker.send(frame_with_shift(number, 0).frame);
    renewing.await_if<Predictions>([number](const auto& p) { return p.tracker_frame == number; });
    std::this_thread::sleep_for(50ms);
  }
  CHECK(daemon.count(Count::leases_expired) == 1);
  silent.discard();
  tracker.send(frame_with_shift(21, 0).frame);
  renewing.await_if<Predictions>([](const auto& p) { return p.tracker_frame == 21; });
  CHECK_FALSE(silent.receive(50ms).has_value());
}

TEST_CASE("A subscriber gets no more than the rate it asked for") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient slow(daemon.runtime.client_port());
  FakeClient all(daemon.runtime.client_port());
  slow.ask<SubscribeReply>(Subscribe{.what = protocol::kTargets, .lease_s = 60, .rate_hz = 50});
  all.ask<SubscribeReply>(Subscribe{.what = protocol::kTargets, .lease_s = 60, .rate_hz = 0});
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint32_t number = 1; number <= 200; ++number) {
    tracker.send(frame_with_shift(number, 0).frame);
    all.await_if<Predictions>([number](const auto& p) { return p.tracker_frame == number; });
    std::this_thread::sleep_for(4ms);
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  int received = 0;
  while (const auto message = slow.receive(0ms)) {
    received += std::holds_alternative<Predictions>(message->message) ? 1 : 0;
  }
  CHECK(received <= 50 * elapsed.count() + 2);
  CHECK(received >= 0.7 * 50 * elapsed.count());
}

TEST_CASE("Datagrams to one client are numbered without a gap, in one session") {
  RunningDaemon daemon;
  FakeClient client(daemon.runtime.client_port());
  FakeClient other(daemon.runtime.client_port());
  std::uint32_t last = 0;
  std::uint32_t session = 0;
  for (int i = 0; i < 20; ++i) {
    client.send(protocol::QueryTargets{});
    client.await<Predictions>();
    other.ask<Predictions>(protocol::QueryTargets{});
    if (i > 0) {
      CHECK(client.header.envelope.sequence == last + 1);
      CHECK(client.header.envelope.session == session);
    }
    last = client.header.envelope.sequence;
    session = client.header.envelope.session;
  }
}

TEST_CASE("A request that the network doubled is answered once, one that overtook a later one does not undo it") {
  RunningDaemon daemon;
  FakeClient client(daemon.runtime.client_port());
  std::array<std::uint8_t, protocol::kMaxDatagram> buffer;
  const auto send = [&](std::uint32_t sequence, const auto& request) {
    const auto size = protocol::encode_client_message({5, sequence, 0}, request, buffer);
    client.send_bytes(std::span(buffer).first(size));
  };
  send(10, protocol::QueryTargets{});
  send(10, protocol::QueryTargets{});
  client.await<Predictions>();
  CHECK_FALSE(client.receive(50ms).has_value());
  CHECK(daemon.count(Count::requests_repeated) == 1);
  send(12, protocol::Unsubscribe{});
  client.await<SubscribeReply>();
  send(11, Subscribe{});
  CHECK_FALSE(client.receive(50ms).has_value());
  CHECK(daemon.count(Count::requests_repeated) == 2);
}

TEST_CASE("What no request is, is answered by an error that names the gate, and counted") {
  RunningDaemon daemon;
  FakeClient client(daemon.runtime.client_port());
  CHECK(client.ask<protocol::Error>(protocol::HelloReply{name_of("x"), name_of("x"), name_of("x"), name_of("x")})
            .reason == protocol::ErrorReason::not_a_request);
  std::array<std::uint8_t, protocol::kMaxDatagram> buffer;
  const auto size = protocol::encode_client_message({77, 100, 0}, protocol::QueryTargets{}, buffer);
  buffer[5] = 0x55;  // no such type
  client.send_bytes(std::span(buffer).first(size));
  const auto error = client.await<protocol::Error>();
  CHECK(error.reason == protocol::ErrorReason::refused);
  CHECK(error.refusal == protocol::ClientRefusal::unknown_type);
  CHECK(error.request_type == 0x55);
  CHECK(client.header.envelope.in_reply_to == 100);
  // An error is never answered.
  client.send(protocol::Error{});
  buffer[5] = static_cast<std::uint8_t>(protocol::MessageType::error);
  client.send_bytes(std::span(buffer).first(size));
  CHECK_FALSE(client.receive(50ms).has_value());
}

TEST_CASE("Garbage of every length on the clients' port is counted, answered only where it speaks our protocol") {
  RunningDaemon daemon;
  FakeClient client(daemon.runtime.client_port());
  FakeClient vandal(daemon.runtime.client_port());
  std::mt19937 random(2);
  std::vector<std::uint8_t> bytes;
  for (std::size_t length = 0; length <= 1500; ++length) {
    bytes.resize(length);
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::uint8_t>(random()); });
    vandal.send_bytes(bytes);
    if (length % 64 == 0) std::this_thread::sleep_for(1ms);
  }
  REQUIRE(eventually([&] { return daemon.count(Count::client_datagrams) == 1501; }));
  CHECK_FALSE(vandal.receive(20ms).has_value());
  const auto counters = read_counters(client);
  CHECK(counters.at("client:too_short") == 24);
  CHECK(counters.at("client:too_long") == 100);
  CHECK(counters.at("client:bad_magic") == 1501 - 24 - 100);
  CHECK(counters.at("client:accepted") >= 1);
}

TEST_CASE("All counters have names of their own, and status shows them") {
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  std::set<std::string> names;
  for (std::size_t i = 0; i < daemon::Counters::kSize; ++i) {
    const std::string name = daemon::Counters::name(i);
    CHECK(name.size() <= protocol::Name::kCapacity);
    names.insert(name);
  }
  CHECK(names.size() == daemon::Counters::kSize);
  tracker.send(frame_with_shift(1, 0).marker("X7", Vec3(0, 0, 0)).frame);
  REQUIRE(eventually([&] { return daemon.simulator.steps == 1; }));
  const auto counters = read_counters(client);
  CHECK(counters.at("tracker_datagrams") == 1);
  CHECK(counters.at("tracker:accepted") == 1);
  CHECK(counters.at("frames_stepped") == 1);
  CHECK(counters.at("unknown_names") == 1);
  CHECK(counters.at("frames_all_parts") == 1);
}

TEST_CASE("The daemon ends cleanly in the middle of everything, also if it never ran") {
  auto config = small_config();
  for (int i = 0; i < 5; ++i) {
    RunningDaemon daemon(config, long_scene(3000));
    daemon.simulator.delay_ms = i;
    FakeTracker tracker(daemon.runtime.tracker_port());
    FakeClient client(daemon.runtime.client_port());
    client.ask<SubscribeReply>(
        Subscribe{.what = protocol::kTargets | protocol::kMesh | protocol::kStatus, .lease_s = 60, .rate_hz = 0});
    for (std::uint32_t number = 1; number <= 10; ++number) tracker.send(frame_with_shift(number, 0).frame);
    client.send(protocol::QueryTopology{});
    client.await_if<Predictions>([](const auto& p) { return p.tracker_frame > 0; });
    daemon.stop();
    CHECK(daemon.simulator.steps > 0);
  }
  FakeSimulator simulator;
  const daemon::Runtime never_run(config, simulator);
  CHECK(never_run.tracker_port() != never_run.client_port());
}

TEST_CASE("A busy port is refused in one line that names it") {
  RunningDaemon daemon;
  auto config = small_config();
  const bool tracker_busy = GENERATE(true, false);
  (tracker_busy ? config.tracker.port : config.clients.port) =
      tracker_busy ? daemon.runtime.tracker_port() : daemon.runtime.client_port();
  FakeSimulator simulator;
  const std::string port = std::to_string(tracker_busy ? config.tracker.port : config.clients.port);
  CHECK_THROWS_WITH(daemon::Runtime(config, simulator),
                    Catch::Matchers::Contains(port) && Catch::Matchers::Contains("in use") &&
                        Catch::Matchers::Contains(tracker_busy ? "tracker" : "clients"));
}
