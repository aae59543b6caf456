#include "daemon/prediction_client.hpp"

#include <catch2/catch.hpp>

#include "daemon/monotonic_clock.hpp"
#include "daemon/subscription.hpp"
#include "daemon/tracker_sender.hpp"
#include "tests/daemon/fake_daemon.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

constexpr Patience kQuick{std::chrono::milliseconds(40), 8};

std::vector<std::string> many_names(const std::string& prefix, int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back(prefix + std::to_string(i));
  return names;
}

FakeDaemonScript with_mesh(int nodes, int tets) {
  FakeDaemonScript script;
  for (int i = 0; i < nodes; ++i) script.nodes.push_back({0.1 * i, -0.2 * i, 1.0 / (i + 1)});
  for (int i = 0; i < tets; ++i) {
    const auto n = std::uint32_t(i % (nodes - 3));
    script.tets.push_back({n, n + 1, n + 2, n + 3});
  }
  return script;
}

}  // namespace

TEST_CASE("A daemon introduces itself") {
  const FakeDaemon daemon({});
  PredictionClient client(daemon.clients(), {}, kQuick);
  CHECK(client.hello().version.view() == "9.9.9");
}

TEST_CASE("A table of names comes in pieces, some of which are lost") {
  FakeDaemonScript script;
  script.targets = many_names("T", 130);  // three datagrams
  script.loses = [](std::uint64_t datagram) { return datagram == 1 || datagram == 3; };
  const FakeDaemon daemon(script);
  PredictionClient client(daemon.clients(), {}, kQuick);
  CHECK(client.names(protocol::NameKind::target) == script.targets);
}

TEST_CASE("An empty table of names is an answer") {
  const FakeDaemon daemon({});
  PredictionClient client(daemon.clients(), {}, kQuick);
  CHECK(client.names(protocol::NameKind::marker).empty());
}

TEST_CASE("A mesh is put together from chunks, the first tries of which are incomplete") {
  FakeDaemonScript script = with_mesh(700, 500);
  script.loses = [](std::uint64_t datagram) { return datagram < 30 && datagram % 4 == 2; };
  const FakeDaemon daemon(script);
  PredictionClient client(daemon.clients(), {}, kQuick);
  const ReceivedMesh snapshot = client.mesh(protocol::Precision::float64);
  CHECK(snapshot.nodes == script.nodes);
  CHECK(snapshot.tracker_frame == 5);
  CHECK(client.cells(protocol::CellKind::tetrahedron) == script.tets);
}

TEST_CASE("A mesh in float32 is right to float32") {
  const FakeDaemonScript script = with_mesh(250, 1);
  const FakeDaemon daemon(script);
  PredictionClient client(daemon.clients(), {}, kQuick);
  const auto nodes = client.mesh(protocol::Precision::float32).nodes;
  REQUIRE(nodes.size() == 250);
  CHECK(nodes[249][0] == Approx(24.9).epsilon(1e-6));
}

TEST_CASE("Half of a daemon's datagrams may be lost") {
  FakeDaemonScript script;
  script.loses = [](std::uint64_t datagram) { return datagram % 2 == 0; };
  const FakeDaemon daemon(script);
  PredictionClient client(daemon.clients(), {}, kQuick);
  CHECK(client.hello().model.view() == "fake");
  const DaemonStatus status = client.status();
  REQUIRE(status.counters.size() == 1);
  CHECK(status.counters[0] == std::pair<std::string, std::uint64_t>{"frames", 100});
  CHECK(client.targets().targets.size() == 0);  // no tracker frame yet: the fake knows no rest positions
}

TEST_CASE("A daemon that is not there is said to be not there") {
  Endpoint gone;
  {
    const FakeDaemon daemon({});
    gone = daemon.clients();
  }
  PredictionClient client(gone, {}, {std::chrono::milliseconds(5), 3});
  CHECK_THROWS_WITH(client.hello(), Catch::Contains("no answer from " + to_string(gone)));
}

TEST_CASE("An answer that never comes in full is said to be incomplete") {
  FakeDaemonScript script = with_mesh(700, 1);
  script.loses = [](std::uint64_t datagram) { return datagram % 13 == 5; };  // 13 datagrams: always the same is lost
  const FakeDaemon daemon(script);
  PredictionClient client(daemon.clients(), {}, {std::chrono::milliseconds(20), 3});
  CHECK_THROWS_WITH(client.mesh(protocol::Precision::float64), Catch::Contains("never came in full"));
}

TEST_CASE("A refusal is an error with its reason") {
  FakeDaemonScript script;
  script.mesh_not_available = true;
  const FakeDaemon daemon(script);
  PredictionClient client(daemon.clients(), {}, kQuick);
  CHECK_THROWS_AS(client.mesh(protocol::Precision::float32), RequestRefused);
}

TEST_CASE("A subscription streams an answer to every frame") {
  const FakeDaemon daemon({});
  PredictionClient client(daemon.clients(), {}, kQuick);
  Subscription subscription(client, protocol::kTargets, 0.0);
  const auto granted = subscription.receive(monotonic_ns() + 1'000'000'000);
  REQUIRE(granted);
  CHECK(std::holds_alternative<protocol::SubscribeReply>(granted->message));

  TrackerSender sender(daemon.tracker());
  AnswerJoiner joiner;
  for (std::uint32_t number = 1; number <= 5; ++number) {
    protocol::TrackerFrame frame;
    frame.frame_number = number;
    frame.stamp_ns = 1000 * number;
    frame.truth.push_back({*protocol::Name::from("T2"), {1, 2, 3}});
    sender.send(frame);
    const auto message = subscription.receive(monotonic_ns() + 1'000'000'000);
    REQUIRE(message);
    const auto* part = std::get_if<protocol::Predictions>(&message->message);
    REQUIRE(part != nullptr);
    const auto answer = joiner.add(*part, message->receive_ns);
    REQUIRE(answer);
    CHECK(answer->frame.tracker_frame == number);
    CHECK(answer->targets[1].position == std::array<double, 3>{1.3, 2, 3.4});
  }
}

TEST_CASE("Parts of an answer are joined in any order, half answers are given up") {
  protocol::Predictions first, second;
  first.part_count = second.part_count = 2;
  second.part = 1;
  for (std::uint16_t i = 0; i < 10; ++i) first.targets.push_back({.index = i});
  second.targets.push_back({.index = 10});
  AnswerJoiner joiner;
  first.tracker_frame = second.tracker_frame = 1;
  CHECK_FALSE(joiner.add(second, 5));
  CHECK_FALSE(joiner.add(second, 5));  // again: nothing new
  const auto answer = joiner.add(first, 6);
  REQUIRE(answer);
  REQUIRE(answer->targets.size() == 11);
  for (std::uint16_t i = 0; i < 11; ++i) CHECK(answer->targets[i].index == i);

  first.tracker_frame = 2;
  CHECK_FALSE(joiner.add(first, 7));
  first.tracker_frame = second.tracker_frame = 3;
  CHECK_FALSE(joiner.add(second, 8));  // the other half of frame 2 never came
  CHECK(joiner.add(first, 9));
}
