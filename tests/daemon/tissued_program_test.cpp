// The program itself: command line, exit codes, what it prints, how it ends.
#include <sched.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/daemon/child_program.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

struct Outcome {
  int code;
  std::string out;
  std::string err;
};

Outcome run(const std::vector<std::string>& arguments) {
  ChildProgram program(TISSUED_BINARY, arguments);
  const int code = program.wait();
  return {code, program.rest_of_stdout(), program.rest_of_stderr()};
}

bool is_one_line(const std::string& text) {
  return std::count(text.begin(), text.end(), '\n') == 1 && text.back() == '\n';
}

struct Ports {
  std::uint16_t tracker = 0;
  std::uint16_t clients = 0;
};

Ports read_ports(ChildProgram& program) {
  unsigned tracker = 0;
  unsigned clients = 0;
  const std::string line = program.read_line();
  REQUIRE(std::sscanf(line.c_str(), "listening tracker=%u clients=%u", &tracker, &clients) == 2);
  return {static_cast<std::uint16_t>(tracker), static_cast<std::uint16_t>(clients)};
}

std::string text(int number) { return std::to_string(number); }

}  // namespace

TEST_CASE("tissued refuses a model that it cannot read, by name") {
  const Outcome outcome =
      run({"--bundle", TISSUED_SOURCE_DIR "/config/demo", "--model", "/nowhere/model.json", "--check"});
  CHECK(outcome.code == 2);
  CHECK(is_one_line(outcome.err));
  CHECK_THAT(outcome.err, Contains("/nowhere/model.json"));
}

TEST_CASE("tissued tells its version and its schema") {
  const Outcome version = run({"--version"});
  CHECK(version.code == 0);
  CHECK_THAT(version.out, StartsWith("tissued " TISSUED_VERSION));
  const Outcome schema = run({"--print-schema"});
  CHECK(schema.code == 0);
  CHECK(nlohmann::json::parse(schema.out).at("$id") == "tissued-config/1");
}

TEST_CASE("tissued refuses a wrong command line with code 2") {
  const std::vector<std::string> arguments =
      GENERATE(std::vector<std::string>{}, std::vector<std::string>{"--nonsense"},
               std::vector<std::string>{"--bundle", "a", "--config", "b"},
               std::vector<std::string>{"--bundle", "a", "--tracker-port", "70000"},
               std::vector<std::string>{"--bundle", "a", "--log-level", "loud"});
  const Outcome outcome = run(arguments);
  CHECK(outcome.code == 2);
  CHECK(outcome.out.empty());
  CHECK_FALSE(outcome.err.empty());
}

TEST_CASE("tissued --check says in one line that all is well, or what is not") {
  const TemporaryFolder folder;
  write_cube_bundle(folder);
  SECTION("a good bundle") {
    const Outcome outcome = run({"--bundle", folder.path(), "--check"});
    CHECK(outcome.code == 0);
    CHECK(is_one_line(outcome.out));
    CHECK_THAT(outcome.out, Contains("8 nodes") && Contains("6 tetrahedra") && Contains("4 markers"));
    CHECK(outcome.err.empty());
  }
  SECTION("a good configuration, in place of an option") {
    const auto file = folder.write("tissued.json", R"({"format": "tissued-config/1", "bundle": "."})");
    CHECK(run({"--check", file}).code == 0);
  }
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& what) {
    const Outcome outcome = run(arguments);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK(is_one_line(outcome.err));
    CHECK_THAT(outcome.err, StartsWith("tissued: ") && Contains(what));
  };
  SECTION("a value beyond its limit") {
    refused({"--bundle", folder.path(), "--check", "--set", "simulator.iterations=0"}, "iterations");
  }
  SECTION("an unknown key") {
    const auto file = folder.write("tissued.json", R"({"format": "tissued-config/1", "bundle": ".", "speed": 9})");
    refused({"--check", "--config", file}, "speed");
  }
  SECTION("a file that is not there") { refused({"--check", folder.path() / "none.json"}, "none.json"); }
  SECTION("a mesh that is not there") {
    std::filesystem::remove(folder.path() / "mesh.msh");
    refused({"--bundle", folder.path(), "--check"}, "mesh.msh");
  }
  SECTION("a mesh that is broken") {
    folder.write("mesh.msh", cube_mesh().substr(0, 300));
    refused({"--bundle", folder.path(), "--check"}, "mesh.msh");
  }
  SECTION("a mesh without the pad's surface") {
    std::string mesh = cube_mesh();
    mesh.replace(mesh.find("\"A1\""), 4, "\"B1\"");
    folder.write("mesh.msh", mesh);
    refused({"--bundle", folder.path(), "--check"}, "A1");
  }
}

TEST_CASE("tissued serves on the ports it prints, quietly, and ends with 0 on a signal") {
  const int signal = GENERATE(SIGINT, SIGTERM);
  const bool talkative = GENERATE(false, true);
  const TemporaryFolder folder;
  std::vector<std::string> arguments{"--bundle", write_cube_bundle(folder), "--tracker-port",
                                     "0",        "--client-port",           "0"};
  if (talkative) arguments.insert(arguments.end(), {"--log-level", "info"});
  ChildProgram program(TISSUED_BINARY, arguments);
  const Ports ports = read_ports(program);
  FakeTracker tracker(ports.tracker);
  FakeClient client(ports.clients);
  CHECK(client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")}).model.view() == "cube");
  client.ask<protocol::SubscribeReply>(protocol::Subscribe{.what = protocol::kTargets, .lease_s = 60, .rate_hz = 0});
  for (std::uint32_t number = 1; number <= 5; ++number) {
    FrameBuilder frame(number);
    frame.stamp(number * std::uint64_t{10'000'000}).marker("M1", core::Vec3(20, 20, 40));
    tracker.send(frame.frame);
    client.await_if<protocol::Predictions>([&](const auto& p) { return p.tracker_frame == number; });
  }
  program.signal(signal);
  CHECK(program.wait() == 0);
  CHECK(program.rest_of_stdout().empty());
  const std::string log = program.rest_of_stderr();
  if (talkative) {
    CHECK_THAT(log, Contains("done: 5 frames stepped, 0 skipped"));
  } else {
    CHECK(log.empty());
  }
}

TEST_CASE("tissued ends with 1 and one line where a port is taken") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  const LoopbackSocket taken;
  const std::string option = GENERATE("--tracker-port", "--client-port");
  const std::string other = option == "--tracker-port" ? "--client-port" : "--tracker-port";
  const Outcome outcome = run({"--bundle", bundle, option, text(taken.port()), other, "0"});
  CHECK(outcome.code == 1);
  CHECK(outcome.out.empty());
  CHECK(is_one_line(outcome.err));
  CHECK_THAT(outcome.err, Contains(text(taken.port())) && Contains("in use"));
}

TEST_CASE("tissued --realtime runs its threads in real time, or says that it may not") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  ChildProgram program(TISSUED_BINARY, {"--bundle", bundle, "--tracker-port", "0", "--client-port", "0", "--realtime"});
  read_ports(program);
  int in_real_time = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + text(program.id()) + "/task")) {
    in_real_time += ::sched_getscheduler(std::stoi(task.path().filename())) == SCHED_RR ? 1 : 0;
  }
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  const std::string log = program.rest_of_stderr();
  if (log.empty()) {
    CHECK(in_real_time >= 2);
  } else {
    CHECK_THAT(log, Contains("no real-time scheduling"));
  }
}

TEST_CASE("tissued warns aloud where more than this machine can reach it") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  ChildProgram program(TISSUED_BINARY, {"--bundle", bundle, "--tracker-port", "0", "--client-port", "0", "--set",
                                        "clients.address=0.0.0.0"});
  read_ports(program);
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  CHECK_THAT(program.rest_of_stderr(), Contains("clients") && Contains("0.0.0.0") && Contains("ANYBODY"));
}
