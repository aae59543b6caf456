// What a running daemon takes on of a configuration that was changed.
#include "daemon/reload.hpp"

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "tests/daemon/child_program.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using Strings = std::vector<std::string>;

namespace {

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

std::string config_text(const std::string& more) {
  return R"({"format": "tissued-config/1", "bundle": ".", "alarm": {"enabled": false},
            "tracker": {"port": 0}, "clients": {"port": 0}, )" +
         more + "}";
}

}  // namespace

TEST_CASE("Every change is either taken on or said to need a start") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  const auto load = [&](const Strings& overrides) { return config::config_for_bundle(bundle, overrides); };
  const auto running = load({});
  const auto needs = [&](const Strings& overrides) {
    return daemon::changes_that_need_a_start(running, load(overrides));
  };
  CHECK(needs({}).empty());
  CHECK(needs({"log.level=info", "staleness.stale_after_ms=50", "staleness.lost_after_ms=60"}).empty());
  CHECK(needs({"clients.lease_s=3", "clients.max_requests_per_s=3"}).empty());
  CHECK(needs({"simulator.iterations=3"}) == Strings{"/simulator/iterations"});
  CHECK(needs({"material.youngs_modulus=3", "tracker.port=7"}) == Strings{"/material/youngs_modulus", "/tracker/port"});
  CHECK(needs({"clients.port=7", "clients.address=127.0.0.2", "clients.max_subscribers=2"}).size() == 3);
  CHECK(needs({"tracker.peer=10.0.0.1", "tracker.peer_port=4"}) == Strings{"/tracker/peer", "/tracker/peer_port"});
  CHECK(needs({"record=a.rec", "record_max_mb=7"}) == Strings{"/record", "/record_max_mb"});
  CHECK(daemon::changes_that_need_a_start(load({"simulator.iterations=3"}), running) ==
        Strings{"/simulator/iterations"});
}

TEST_CASE("SIGHUP makes tissued read its configuration again, and whatever it says frames are answered") {
  const TemporaryFolder folder;
  write_cube_bundle(folder);
  const auto file = folder.path() / "live.json";
  write(file, config_text(R"("log": {"level": "warn"})"));
  ChildProgram program(TISSUED_BINARY, {"--config", file.string()});
  unsigned tracker = 0, clients = 0;
  REQUIRE(std::sscanf(program.read_line().c_str(), "listening tracker=%u clients=%u", &tracker, &clients) == 2);
  FakeTracker frames(static_cast<std::uint16_t>(tracker));
  FakeClient client(static_cast<std::uint16_t>(clients));
  std::uint32_t number = 0;
  const auto is_answered = [&] {
    ++number;
    frames.send(FrameBuilder(number).stamp(number * std::uint64_t{10'000'000}).frame);
    return eventually(
        [&] { return client.ask<protocol::Predictions>(protocol::QueryTargets{}).tracker_frame == number; });
  };
  const auto hang_up = [&](const std::string& text) {
    write(file, text);
    program.signal(SIGHUP);
    for (int i = 0; i < 20; ++i) CHECK(is_answered());
    std::this_thread::sleep_for(200ms);
  };
  CHECK(is_answered());
  hang_up(config_text(R"("log": {"level": "info"}, "staleness": {"stale_after_ms": 50})"));
  hang_up(config_text(R"("simulator": {"iterations": 3})"));
  hang_up("{");
  hang_up(config_text(R"("simulator": {"iterations": -3})"));
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  const std::string log = program.rest_of_stderr();
  CHECK_THAT(log, Contains("configuration read again\n"));
  CHECK_THAT(log, Contains("changed, but only a start takes it on: /simulator/iterations"));
  CHECK_THAT(log, Contains("not read again, the one so far stays") && Contains("-3 is below the minimum 1"));
}
