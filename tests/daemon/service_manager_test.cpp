// What a service manager hears, from the program itself and from a runtime whose simulator gets stuck.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "tests/daemon/child_program.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/notify_socket.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using Clock = std::chrono::steady_clock;

namespace {

std::vector<std::string> cube_arguments(const TemporaryFolder& folder) {
  return {"--bundle", write_cube_bundle(folder), "--tracker-port", "0", "--client-port", "0"};
}

std::uint16_t port_of(const std::string& line, const std::string& name) {
  std::smatch found;
  if (!std::regex_search(line, found, std::regex(name + "=([0-9]+)"))) throw std::runtime_error("no port in " + line);
  return static_cast<std::uint16_t>(std::stoi(found[1]));
}

bool says(const std::string& message, const std::string& assignment) {
  return ("\n" + message).find("\n" + assignment + "\n") != std::string::npos;
}

int open_sockets(pid_t process) {
  int sockets = 0;
  for (const auto& file : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/fd")) {
    std::error_code gone;
    sockets += std::filesystem::read_symlink(file.path(), gone).string().starts_with("socket:") ? 1 : 0;
  }
  return sockets;
}

// A variable of this process, while a test needs it.
class EnvironmentVariable {
 public:
  EnvironmentVariable(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~EnvironmentVariable() { ::unsetenv(name_); }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

 private:
  const char* name_;
};

}  // namespace

TEST_CASE("A service manager hears ready, status, alive in time, and stopping, in this order") {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "notify";
  const NotifySocket manager(GENERATE(false, true) ? path : "@" + path);
  ChildProgram program(TISSUED_BINARY, cube_arguments(folder), {manager.variable(), "WATCHDOG_USEC=2000000"});

  const std::string first = manager.receive();
  CHECK(says(first, "READY=1"));
  CHECK(says(first, "WATCHDOG=1"));
  CHECK_THAT(first, Contains("STATUS=0 frames/s, no_data, alarm "));
  const std::string line = program.read_line();
  FakeClient client(port_of(line, "clients"));  // ready means that it answers
  CHECK(client.ask<protocol::Predictions>(protocol::QueryTargets{}).targets.size() > 0);

  for (int i = 0; i < 3; ++i) {
    const auto before = Clock::now();
    const std::string next = manager.receive();
    const auto gap = Clock::now() - before;
    CHECK(says(next, "WATCHDOG=1"));
    CHECK_FALSE(says(next, "READY=1"));
    CHECK(gap > 500ms);
    CHECK(gap < 2s);
  }
  program.signal(SIGTERM);
  CHECK(says(manager.receive(), "STOPPING=1"));
  CHECK(program.wait() == 0);
  CHECK_THROWS(manager.receive(0ms));
}

TEST_CASE("A service manager is told how many frames come and what they are worth") {
  const TemporaryFolder folder;
  const NotifySocket manager(folder.path() / "notify");
  ChildProgram program(TISSUED_BINARY, cube_arguments(folder), {manager.variable(), "WATCHDOG_USEC=100000"});
  FakeTracker tracker(port_of(program.read_line(), "tracker"));
  const std::regex busy("STATUS=([1-9][0-9]*) frames/s, (valid|degraded), alarm .*\n");
  std::uint32_t number = 0;
  CHECK(eventually(
      [&] {
        FrameBuilder frame(++number);
        frame.stamp(number * std::uint64_t{10'000'000}).marker("M1", core::Vec3(20, 20, 40));
        tracker.send(frame.frame);
        return std::regex_search(manager.receive(), busy);
      },
      20s));
}

TEST_CASE("Without a watchdog nobody is told that the daemon is alive") {
  const TemporaryFolder folder;
  const NotifySocket manager(folder.path() / "notify");
  // One that is meant for another process is none.
  const auto watchdog =
      GENERATE(std::vector<std::string>{}, std::vector<std::string>{"WATCHDOG_USEC=2000000", "WATCHDOG_PID=1"});
  std::vector<std::string> environment = watchdog;
  environment.push_back(manager.variable());
  ChildProgram program(TISSUED_BINARY, cube_arguments(folder), environment);
  const std::string first = manager.receive();
  CHECK(says(first, "READY=1"));
  CHECK_FALSE(says(first, "WATCHDOG=1"));
}

TEST_CASE("Without a service manager there is no socket for one") {
  const TemporaryFolder folder;
  ChildProgram alone(TISSUED_BINARY, cube_arguments(folder), {"NOTIFY_SOCKET="});
  alone.read_line();
  CHECK(open_sockets(alone.id()) == 2);  // tracker, clients

  const NotifySocket manager(folder.path() / "notify");
  ChildProgram managed(TISSUED_BINARY, cube_arguments(folder), {manager.variable()});
  managed.read_line();
  CHECK(open_sockets(managed.id()) == 3);
}

TEST_CASE("A service manager that does not listen holds nothing up") {
  const TemporaryFolder folder;
  std::optional<NotifySocket> manager(folder.path() / "notify");
  ChildProgram program(TISSUED_BINARY, cube_arguments(folder), {manager->variable(), "WATCHDOG_USEC=20000"});
  const std::uint16_t clients = port_of(program.read_line(), "clients");
  std::this_thread::sleep_for(2s);  // 200 messages, of which the kernel keeps some ten (net.unix.max_dgram_qlen)
  FakeClient client(clients);
  CHECK(client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")}).model.view() == "cube");

  SECTION("full") {}
  SECTION("gone") {
    manager.reset();
    std::this_thread::sleep_for(50ms);
    CHECK(client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")}).model.view() == "cube");
  }
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
}

TEST_CASE("A service manager that comes late hears of readiness all the same") {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "notify";
  ChildProgram program(TISSUED_BINARY, cube_arguments(folder), {"NOTIFY_SOCKET=" + path, "WATCHDOG_USEC=20000"});
  program.read_line();
  std::this_thread::sleep_for(100ms);
  const NotifySocket manager(path);
  CHECK(says(manager.receive(), "READY=1"));
  CHECK_FALSE(says(manager.receive(), "READY=1"));
}

TEST_CASE("A malformed environment of a service is refused in one line") {
  const auto [variables, blamed] = GENERATE(table<std::vector<std::string>, std::string>(
      {{{"NOTIFY_SOCKET=run/notify"}, "NOTIFY_SOCKET: \"run/notify\""},
       {{"NOTIFY_SOCKET=@"}, "NOTIFY_SOCKET: \"@\""},
       {{"NOTIFY_SOCKET=/"}, "NOTIFY_SOCKET: \"/\""},
       {{"NOTIFY_SOCKET=/" + std::string(107, 'x')}, "NOTIFY_SOCKET: \"/x"},
       {{"NOTIFY_SOCKET=/tmp/n", "WATCHDOG_USEC=soon"}, "WATCHDOG_USEC: "},
       {{"NOTIFY_SOCKET=/tmp/n", "WATCHDOG_USEC=0"}, "WATCHDOG_USEC: "}}));
  const TemporaryFolder folder;
  ChildProgram program(TISSUED_BINARY, cube_arguments(folder), variables);
  CHECK(program.wait() == 1);
  const std::string error = program.rest_of_stderr();
  CHECK(std::count(error.begin(), error.end(), '\n') == 1);
  CHECK_THAT(error, Contains(blamed));
}

TEST_CASE("A simulation that is stuck in a step is alive for as long as the watchdog waits, and no longer") {
  const TemporaryFolder folder;
  const NotifySocket manager(folder.path() / "notify");
  const EnvironmentVariable socket("NOTIFY_SOCKET", folder.path() / "notify");
  const EnvironmentVariable watchdog("WATCHDOG_USEC", "1100000");
  RunningDaemon daemon;
  FakeTracker tracker(daemon.runtime.tracker_port());
  CHECK(says(manager.receive(), "WATCHDOG=1"));

  daemon.simulator.stuck = true;
  const auto began = Clock::now();
  tracker.send(frame_with_shift(1, 1.0).frame);
  std::string message;
  do {
    message = manager.receive();
  } while (says(message, "WATCHDOG=1") && Clock::now() - began < 20s);
  CHECK(Clock::now() - began > 1s);  // a step may be as long as the watchdog waits
  for (int i = 0; i < 3; ++i) {
    CHECK_FALSE(says(message, "WATCHDOG=1"));
    CHECK_THAT(message, Contains("in one step for "));
    message = manager.receive();
  }
  // The sockets are served all the while.
  FakeClient client(daemon.runtime.client_port());
  client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")});

  daemon.simulator.stuck = false;
  REQUIRE(eventually([&] { return daemon.simulator.steps == 1; }));
  CHECK(eventually([&] { return says(manager.receive(), "WATCHDOG=1"); }));
  CHECK_THAT(manager.receive(), !Contains("in one step for"));
}
