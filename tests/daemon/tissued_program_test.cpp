// The program itself: command line, exit codes, what it prints, how it ends.
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
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

// Those that a thread of this name may run on.
std::vector<int> cpus_of(const ChildProgram& program, const std::string& thread) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + text(program.id()) + "/task")) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    cpu_set_t allowed;
    if (name != thread || ::sched_getaffinity(std::stoi(task.path().filename()), sizeof allowed, &allowed) != 0)
      continue;
    std::vector<int> cpus;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (CPU_ISSET(cpu, &allowed)) cpus.push_back(cpu);
    }
    if (task.path().filename() == text(program.id()) || thread != "tissued") return cpus;
  }
  return {};
}

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

TEST_CASE("tissued pins its threads to the CPUs of the configuration") {
  if (std::thread::hardware_concurrency() < 2) {
    WARN("skipped: one CPU");
    return;
  }
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  const bool realtime = GENERATE(true, false);
  std::vector<std::string> arguments{"--bundle", bundle, "--tracker-port", "0", "--client-port", "0"};
  arguments.insert(arguments.end(), {"--set", "realtime.simulation_cpu=1", "--set", "realtime.io_cpu=0"});
  if (realtime) arguments.push_back("--realtime");
  ChildProgram program(TISSUED_BINARY, arguments);
  read_ports(program);
  if (realtime) {
    CHECK(cpus_of(program, "simulation") == std::vector<int>{1});
    CHECK(cpus_of(program, "tissued") == std::vector<int>{0});
  } else {
    CHECK(cpus_of(program, "simulation").size() > 1);
  }
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  CHECK_THAT(program.rest_of_stderr(), !Contains("CPU"));
}

TEST_CASE("tissued says for everything that it may not have what limit to raise, and serves all the same") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  std::vector<std::string> command{"prlimit", "--rtprio=0", "--memlock=65536"};
  if (::geteuid() == 0) {
    command.insert(command.end(), {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--inh-caps=-all",
                                   "--bounding-set=-all"});
  }
  command.insert(command.end(), {TISSUED_BINARY, "--bundle", bundle, "--tracker-port", "0", "--client-port", "0"});
  command.insert(command.end(), {"--realtime", "--set", "realtime.simulation_cpu=1023", "--set", "realtime.io_cpu=0"});
  ChildProgram program(command.front(), {command.begin() + 1, command.end()});
  FakeClient client(read_ports(program).clients);
  CHECK(client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")}).model.view() == "cube");
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  const std::string log = program.rest_of_stderr();
  CHECK_THAT(log, Contains("of the simulation: Operation not permitted; raise the limit 0 to 10") &&
                      Contains("of the sockets: Operation not permitted; raise the limit 0 to 11") &&
                      Contains("the simulation is not pinned to CPU 1023: Invalid argument; this process may use "));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which lock no memory, and say that they did
  CHECK(std::count(log.begin(), log.end(), '\n') == 4);
  CHECK_THAT(log, Contains("memory may be paged out: Cannot allocate memory; raise the limit 65536 bytes"));
#endif
}

TEST_CASE("tissued warns aloud where more than this machine can reach it") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  ChildProgram program(TISSUED_BINARY, {"--bundle", bundle, "--tracker-port", "0", "--client-port", "0", "--set",
                                        "clients.address=0.0.0.0", "--insecure"});
  read_ports(program);
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  CHECK_THAT(program.rest_of_stderr(), Contains("clients") && Contains("0.0.0.0") && Contains("WHOEVER"));
}

TEST_CASE("tissued does not start where more than this machine can reach it, unless there are keys or it is told to") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  ChildProgram program(TISSUED_BINARY, {"--bundle", bundle, "--tracker-port", "0", "--client-port", "0", "--set",
                                        "tracker.address=0.0.0.0"});
  CHECK(program.wait() == 2);
  CHECK_THAT(program.rest_of_stderr(), Contains("--set tracker.address=0.0.0.0") && Contains("/tracker/address") &&
                                           Contains("give a file of `keys`, or say `insecure`"));
}
