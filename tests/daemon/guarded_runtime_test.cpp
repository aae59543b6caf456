// Who is believed, and who is answered how much: the runtime with keys, with unproven addresses, with foreign trackers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "daemon/bound_socket.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/prediction_client.hpp"
#include "daemon/source_filter.hpp"
#include "daemon/subscription.hpp"
#include "daemon/tracker_sender.hpp"
#include "protocol/sealed_contact.hpp"
#include "tests/daemon/child_program.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace tissued::daemon;
using namespace std::chrono_literals;
using protocol::SealRefusal;

namespace {

const Patience kQuick{100ms, 5};

config::PreSharedKey key_of(const std::string& name, config::KeyRole role, std::uint8_t first) {
  config::PreSharedKey key{name, role, {}};
  key.secret.fill(first);
  return key;
}

const config::PreSharedKey kClientKey = key_of("watcher", config::KeyRole::client, 1);
const config::PreSharedKey kTrackerKey = key_of("vicon", config::KeyRole::tracker, 2);

protocol::SecretKey secret(const config::PreSharedKey& key) { return protocol::SecretKey(key.secret); }

config::DaemonConfig sealed_config() {
  config::DaemonConfig config = small_config();
  config.keys = {kClientKey, kTrackerKey};
  return config;
}

Endpoint clients_of(const RunningDaemon& daemon) { return {"127.0.0.1", daemon.runtime.client_port()}; }
Endpoint tracker_of(const RunningDaemon& daemon) { return {"127.0.0.1", daemon.runtime.tracker_port()}; }

bool is_silent(FakeClient& client) { return !client.receive(100ms); }

}  // namespace

TEST_CASE("With keys, their owners send frames and are answered, and their stream goes on") {
  RunningDaemon daemon(sealed_config());
  TrackerSender tracker(tracker_of(daemon), secret(kTrackerKey));
  PredictionClient client(clients_of(daemon), secret(kClientKey), kQuick);
  CHECK(client.hello().model.view() == "small");
  CHECK(client.subscribe({.what = protocol::kTargets}).lease_s > 0);
  for (std::uint32_t i = 1; i <= 3; ++i) {
    CHECK(tracker.send(frame_with_shift(i, 0.5 * i).frame));
    const auto message = client.receive(monotonic_ns() + 5'000'000'000ULL);
    REQUIRE(message.has_value());
    const auto* predictions = std::get_if<protocol::Predictions>(&message->message);
    REQUIRE(predictions != nullptr);
    CHECK(predictions->tracker_frame == i);
    CHECK(predictions->targets[0].position[0] == 5.0 + 0.5 * i);
  }
  CHECK(client.mesh(protocol::Precision::float64).nodes.size() == 4);
  CHECK(tracker.undelivered() == 0);
  CHECK(client.refused() == 0);
}

TEST_CASE("With keys, whoever has none is neither believed nor answered") {
  RunningDaemon daemon(sealed_config());
  FakeClient stranger(daemon.runtime.client_port());
  stranger.send(protocol::QueryTargets{});
  stranger.send(protocol::Subscribe{});
  stranger.send(protocol::Hello{name_of("stranger")});  // of 48 bytes
  CHECK(is_silent(stranger));
  FakeTracker tracker(daemon.runtime.tracker_port());
  tracker.send(frame_with_shift(1, 0.5).frame);
  CHECK(eventually([&] { return daemon.count(Count::tracker_datagrams) == 1; }));
  CHECK(eventually([&] { return daemon.count(SealRefusal::too_short) + daemon.count(SealRefusal::bad_magic) == 4; }));
  CHECK(daemon.count(Count::frames_stepped) == 0);
  CHECK(daemon.count(Count::datagrams_sent) == 0);

  CHECK_THROWS_AS(
      PredictionClient(clients_of(daemon), secret(key_of("x", config::KeyRole::both, 3)), {20ms, 2}).hello(), NoAnswer);
  CHECK(daemon.count(SealRefusal::unknown_key) > 0);
}

TEST_CASE("A key opens the port of its role alone") {
  RunningDaemon daemon(sealed_config());
  CHECK_THROWS_AS(PredictionClient(clients_of(daemon), secret(kTrackerKey), {20ms, 2}).hello(), NoAnswer);
  CHECK_THROWS_WITH(TrackerSender(tracker_of(daemon), secret(kClientKey)), Catch::Contains("with this key"));
  CHECK(daemon.count(SealRefusal::wrong_role) > 1);
}

TEST_CASE("A sealed frame that is sent a second time, or from elsewhere, is not taken again") {
  RunningDaemon daemon(sealed_config());
  const LoopbackSocket socket, elsewhere;
  protocol::SealedContact contact(protocol::SealChannel::tracker, secret(kTrackerKey));
  std::array<std::uint8_t, protocol::kMaxSealed> buffer{};
  const auto first = contact.seal_first_contact(buffer);
  socket.send(daemon.runtime.tracker_port(), std::span(buffer).first(first));
  const auto size = socket.receive(buffer, 5s);
  REQUIRE(size == first);  // no more than the question
  REQUIRE(contact.open(std::span(buffer).first(*size)).refusal == SealRefusal::none);

  const auto packets = FakeTracker::packets_of(frame_with_shift(7, 0.5).frame);
  REQUIRE(packets.size() == 1);
  const auto sealed = std::span(buffer).first(contact.seal(packets[0].view(), buffer));
  for (int i = 0; i < 3; ++i) socket.send(daemon.runtime.tracker_port(), sealed);
  CHECK(eventually([&] { return daemon.count(SealRefusal::replayed) == 2; }));
  std::this_thread::sleep_for(200ms);  // while the stream runs the kernel lets nobody else in
  elsewhere.send(daemon.runtime.tracker_port(), sealed);
  CHECK(eventually([&] { return daemon.count(SealRefusal::wrong_session) == 1; }));
  CHECK(eventually([&] { return daemon.count(Count::frames_stepped) == 1; }));
  CHECK(daemon.count(protocol::TrackerRefusal::none) == 1);
}

TEST_CASE("With keys, the named peer's plain stream is taken, and nobody else's") {
  config::DaemonConfig config = sealed_config();
  config.tracker.peer = GENERATE("127.0.0.1", "127.0.0.2");
  RunningDaemon daemon(config);
  FakeTracker tracker(daemon.runtime.tracker_port());
  tracker.send(frame_with_shift(1, 0.5).frame);
  CHECK(eventually([&] { return daemon.count(Count::tracker_datagrams) == 1; }));
  const bool named = config.tracker.peer == "127.0.0.1";
  CHECK(eventually([&] { return daemon.count(Count::frames_stepped) == (named ? 1 : 0); }));
  CHECK(daemon.count(SealRefusal::bad_magic) + daemon.count(SealRefusal::too_short) == (named ? 0 : 1));
}

TEST_CASE("After the daemon's restart its peers find it again by themselves") {
  config::DaemonConfig config = sealed_config();
  auto daemon = std::make_unique<RunningDaemon>(config);
  config.clients.port = daemon->runtime.client_port();
  config.tracker.port = daemon->runtime.tracker_port();
  TrackerSender tracker(tracker_of(*daemon), secret(kTrackerKey));
  PredictionClient client(clients_of(*daemon), secret(kClientKey), kQuick);
  CHECK(client.hello().model.view() == "small");
  tracker.send(frame_with_shift(1, 0.5).frame);
  daemon.reset();
  daemon = std::make_unique<RunningDaemon>(config);
  CHECK(client.hello().model.view() == "small");
  std::uint32_t frame = 1;
  CHECK(eventually([&] {
    tracker.send(frame_with_shift(++frame, 0.5).frame);
    std::this_thread::sleep_for(10ms);
    return daemon->count(Count::frames_stepped) > 0;
  }));
}

TEST_CASE("A client that begins anew at its old address takes its stream along, sealed for what it is now") {
  RunningDaemon daemon(sealed_config());
  TrackerSender tracker(tracker_of(daemon), secret(kTrackerKey));
  const LoopbackSocket socket;
  std::array<std::uint8_t, protocol::kMaxSealed> buffer{};
  for (std::uint32_t round = 1; round <= 2; ++round) {
    protocol::SealedContact contact(protocol::SealChannel::client, secret(kClientKey));
    const auto receive = [&] { return contact.open(std::span(buffer).first(socket.receive(buffer, 5s).value())); };
    socket.send(daemon.runtime.client_port(), std::span(buffer).first(contact.seal_first_contact(buffer)));
    while (!contact.established()) receive();
    std::array<std::uint8_t, protocol::kMaxDatagram> request{};
    const auto size = round == 1 ? protocol::encode_client_message({round, 1, 0}, protocol::Subscribe{}, request)
                                 : protocol::encode_client_message({round, 1, 0}, protocol::QueryStatus{}, request);
    socket.send(daemon.runtime.client_port(),
                std::span(buffer).first(contact.seal(std::span(request).first(size), buffer)));
    CHECK(receive().refusal == SealRefusal::none);  // the answer
    CHECK(tracker.send(frame_with_shift(round, 0.5).frame));
    CHECK(receive().refusal == SealRefusal::none);  // the stream
  }
}

namespace {

config::DaemonConfig proving_config() {
  config::DaemonConfig config = small_config();
  config.clients.prove_addresses = true;
  return config;
}

template <typename Request>
std::size_t size_of(const Request& request) {
  std::array<std::uint8_t, protocol::kMaxDatagram> buffer{};
  return protocol::encode_client_message({1, 1, 0}, request, buffer);
}

// Of the datagram that comes within 100 ms; 0: none.
std::size_t size_of_answer(const LoopbackSocket& socket) {
  std::array<std::uint8_t, 2048> buffer{};
  return socket.receive(buffer, 100ms).value_or(0);
}

}  // namespace

TEST_CASE("Nobody is sent more than he has sent before he has shown that he receives") {
  RunningDaemon daemon(proving_config());
  const LoopbackSocket socket;
  std::uint32_t sequence = 0;
  const auto answer_to = [&](const auto& request) {
    std::array<std::uint8_t, protocol::kMaxDatagram> buffer{};
    const auto size = protocol::encode_client_message({1, ++sequence, 0}, request, buffer);
    socket.send(daemon.runtime.client_port(), std::span(buffer).first(size));
    const std::size_t answer = size_of_answer(socket);
    CHECK(answer <= size);
    CHECK(size_of_answer(socket) == 0);
    return answer;
  };
  CHECK(answer_to(protocol::QueryTargets{}) == 0);
  CHECK(answer_to(protocol::QueryStatus{}) == 0);
  CHECK(answer_to(protocol::QueryNames{}) == 0);
  CHECK(answer_to(protocol::QueryMesh{}) == 0);
  CHECK(answer_to(protocol::QueryTopology{}) == 0);
  CHECK(answer_to(protocol::Unsubscribe{}) == 0);
  CHECK(answer_to(protocol::Subscribe{}) > 0);
  CHECK(answer_to(protocol::Hello{name_of("h")}) > 0);
  CHECK(answer_to(protocol::HelloReply{}) > 0);
  CHECK(answer_to(protocol::Error{}) == 0);
  CHECK(answer_to(protocol::ProveAddress{}) == size_of(protocol::ProveAddress{}));
  CHECK(answer_to(protocol::ProveAddress{{1, 2, 3}}) == size_of(protocol::ProveAddress{}));
  CHECK(daemon.count(Count::requests_unproven) == 12);
}

TEST_CASE("A cookie is good where it was sent to, and nowhere else") {
  RunningDaemon daemon(proving_config());
  FakeClient client(daemon.runtime.client_port()), other(daemon.runtime.client_port());
  const auto cookie = client.ask<protocol::AddressProof>(protocol::ProveAddress{}).cookie;
  CHECK(cookie != protocol::CookieBytes{});
  CHECK(other.ask<protocol::AddressProof>(protocol::ProveAddress{cookie}).cookie != protocol::CookieBytes{});
  other.send(protocol::QueryTargets{});
  CHECK(is_silent(other));
  CHECK(client.ask<protocol::AddressProof>(protocol::ProveAddress{cookie}).cookie == protocol::CookieBytes{});
  CHECK(client.ask<protocol::Predictions>(protocol::QueryTargets{}).targets.size() == 2);
}

TEST_CASE("tissuectl's client shows by itself that it receives, after a restart of the daemon, too") {
  config::DaemonConfig config = proving_config();
  auto daemon = std::make_unique<RunningDaemon>(config);
  config.clients.port = daemon->runtime.client_port();
  PredictionClient client(clients_of(*daemon), {}, kQuick);
  CHECK(client.targets().frame.validity == protocol::Validity::no_data);
  CHECK(client.names(protocol::NameKind::marker).size() == 4);
  Subscription subscription(client, protocol::kTargets, 100.0);
  CHECK(subscription.receive(monotonic_ns() + 2'000'000'000ULL).has_value());
  daemon.reset();
  daemon = std::make_unique<RunningDaemon>(config);
  CHECK(client.hello().model.view() == "small");
  CHECK(subscription.receive(monotonic_ns() + 2'000'000'000ULL).has_value());
}

TEST_CASE("A second tracker's frames are not mixed with the first one's, and are followed when that is silent") {
  config::DaemonConfig config = small_config();
  config.staleness.stale_after = 400ms;
  RunningDaemon daemon(config);
  FakeTracker first(daemon.runtime.tracker_port()), second(daemon.runtime.tracker_port());
  for (std::uint32_t i = 1; i <= 5; ++i) {
    first.send(frame_with_shift(2 * i, 0.5).frame);
    second.send(frame_with_shift(2 * i + 1, 30.0).frame);
  }
  CHECK(eventually([&] { return daemon.count(protocol::TrackerRefusal::none) == 5; }));
  CHECK(daemon.count(Count::tracker_datagrams) == 5 + daemon.count(Count::foreign_datagrams));
  std::this_thread::sleep_for(500ms);
  second.send(frame_with_shift(12, 30.0).frame);
  CHECK(eventually([&] { return daemon.count(protocol::TrackerRefusal::none) == 6; }));
  first.send(frame_with_shift(13, 0.5).frame);
  std::this_thread::sleep_for(50ms);
  CHECK(daemon.count(protocol::TrackerRefusal::none) == 6);
}

TEST_CASE("A flood from elsewhere takes no room in the stream's socket") {
  const auto address = GENERATE("127.0.0.1", "::1", "::");
  boost::asio::io_context context;
  using boost::asio::ip::udp;
  auto socket = bind_udp(context, "test", address, 0);
  const std::uint16_t port = socket.local_endpoint().port();
  const bool v6 = std::string(address) == "::1";
  const auto target = udp::endpoint(boost::asio::ip::make_address(v6 ? "::1" : "127.0.0.1"), port);
  udp::socket stream(context, target.protocol()), flood(context, target.protocol());
  const std::array<std::uint8_t, 3> bytes{1, 2, 3};
  stream.send_to(boost::asio::buffer(bytes), target);
  udp::endpoint from;
  std::array<std::uint8_t, 8> buffer{};
  REQUIRE(socket.receive_from(boost::asio::buffer(buffer), from) == 3);
  REQUIRE(admit_only(socket.native_handle(), from));
  const auto waiting = [&] {
    std::size_t count = 0;
    boost::system::error_code error;
    udp::endpoint ignored;
    while (socket.receive_from(boost::asio::buffer(buffer), ignored, 0, error) == 3 && !error) ++count;
    return count;
  };
  for (int i = 0; i < 1000; ++i) flood.send_to(boost::asio::buffer(bytes), target);
  stream.send_to(boost::asio::buffer(bytes), target);
  CHECK(waiting() == 1);
  admit_all(socket.native_handle());
  flood.send_to(boost::asio::buffer(bytes), target);
  stream.send_to(boost::asio::buffer(bytes), target);
  CHECK(waiting() == 2);
}

TEST_CASE("What is no tracker's datagram does not win the stream") {
  RunningDaemon daemon;
  FakeTracker stranger(daemon.runtime.tracker_port()), tracker(daemon.runtime.tracker_port());
  stranger.send(std::vector<std::uint8_t>(40, 0xEE));
  tracker.send(frame_with_shift(1, 0.5).frame);
  CHECK(eventually([&] { return daemon.count(protocol::TrackerRefusal::none) == 1; }));
  CHECK(daemon.count(Count::foreign_datagrams) == 0);
}

TEST_CASE("Only the named peer is believed, at the named port") {
  config::DaemonConfig config = small_config();
  config.tracker.peer = "127.0.0.1";
  config.tracker.peer_port = 9;  // nobody here
  RunningDaemon daemon(config);
  FakeTracker tracker(daemon.runtime.tracker_port());
  tracker.send(frame_with_shift(1, 0.5).frame);
  CHECK(eventually([&] { return daemon.count(Count::foreign_datagrams) == 1; }));
  CHECK(daemon.count(protocol::TrackerRefusal::none) == 0);
}

TEST_CASE("A client that asks too often is answered as often as is allowed, and the others are not hindered") {
  config::DaemonConfig config = small_config();
  config.clients.max_requests_per_s = 20;
  RunningDaemon daemon(config);
  FakeClient greedy(daemon.runtime.client_port()), modest(daemon.runtime.client_port());
  const std::uint64_t began_ns = monotonic_ns();
  for (int i = 0; i < 500; ++i) greedy.send(protocol::QueryTargets{});
  CHECK(modest.ask<protocol::HelloReply>(protocol::Hello{name_of("modest")}).model.view() == "small");
  CHECK(eventually(
      [&] { return daemon.count(Count::datagrams_sent) - 1 + daemon.count(Count::requests_limited) == 500; }));
  const double seconds = static_cast<double>(monotonic_ns() - began_ns) * 1e-9;
  const auto answered = daemon.count(Count::datagrams_sent) - 1;
  CHECK(answered >= 20);
  CHECK(static_cast<double>(answered) <= 20.0 * (1.0 + seconds) + 1.0);
}

TEST_CASE("A key made by tissuectl opens tissued, until its line is taken out and SIGHUP sent") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  const std::string at = folder.path().string() + "/";
  const auto shell = [&](const std::string& script) {
    ChildProgram program("sh", {"-c", "cd " + at + " && umask 077 && " + script});
    return program.wait();
  };
  const std::string key = std::string(TISSUECTL_PROGRAM) + " key ";
  REQUIRE(shell(key + "a --role client >a && " + key + "b --role client >b && " + key + "t --role tracker >t") == 0);
  REQUIRE(shell("cat a t >keys") == 0);
  ChildProgram program(TISSUED_BINARY, {"--bundle", bundle, "--keys", at + "keys", "--tracker-port", "0",
                                        "--client-port", "0", "--set", "alarm.enabled=false"});
  unsigned tracker = 0, clients = 0;
  REQUIRE(std::sscanf(program.read_line().c_str(), "listening tracker=%u clients=%u", &tracker, &clients) == 2);
  const std::string query = std::string(TISSUECTL_PROGRAM) + " query hello --from 127.0.0.1:" + std::to_string(clients);
  CHECK(shell(query + " --keys a >out") == 0);
  CHECK(shell(query + " --keys b 2>err") == 1);
  CHECK(shell("grep -q 'with this key among its own' err") == 0);
  CHECK(shell(query + " --keys t 2>err") == 1);
  CHECK(shell("grep -q 't: no key for a client' err") == 0);
  CHECK(shell(query + " 2>err") == 1);
  REQUIRE(shell("cat b t >keys") == 0);
  program.signal(SIGHUP);
  CHECK(eventually([&] { return shell(query + " --keys b >out 2>&1") == 0; }, 20s));
  CHECK(shell(query + " --keys a 2>err") == 1);
  // A bundle that is at fault keeps nobody's key believed, nor does its being the last.
  REQUIRE(shell("mv bundle.json away.json && : >keys") == 0);
  program.signal(SIGHUP);
  CHECK(eventually([&] { return shell(query + " --keys b >out 2>&1") == 1; }, 20s));
  // What cannot be read says nothing about keys.
  REQUIRE(shell("mv away.json bundle.json && cat a t >keys") == 0);
  program.signal(SIGHUP);
  CHECK(eventually([&] { return shell(query + " --keys a >out 2>&1") == 0; }, 20s));
  REQUIRE(shell("echo nonsense >keys") == 0);
  program.signal(SIGHUP);
  std::this_thread::sleep_for(500ms);
  CHECK(shell(query + " --keys a >out 2>&1") == 0);
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  CHECK_THAT(program.rest_of_stderr(), Catch::Matchers::Contains("keys not read again"));
}
