// Log files: how they grow, are renamed and removed, and what becomes of the daemon when they cannot be written.
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "config/config_error.hpp"
#include "daemon/log_output.hpp"
#include "tests/daemon/child_program.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

std::string content(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The number that the last line of a log ends with.
int last_number(const fs::path& file) {
  const std::string text = content(file);
  return std::stoi(text.substr(text.find_last_of(' ')));
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("Log files are renamed before they grow beyond their size, and only so many are kept") {
  const TemporaryFolder folder;
  config::DaemonConfig config;
  config.log = {config::LogLevel::info, folder.path() / "live.log", 10'000, GENERATE(1, 3)};
  const fs::path oldest = folder.path() / "live.2.log";
  daemon::start_logging(config);
  int number = 0;
  for (; number < 1000; ++number) {
    spdlog::info("{} {}", std::string(60, '.'), number);
    spdlog::debug("not of this level");
    if (number % 100 == 99) std::this_thread::sleep_for(50ms);  // what comes too fast is lost, as it should
  }
  spdlog::info("the last one is {}", number);
  spdlog::shutdown();

  REQUIRE(files_in(folder.path()) == static_cast<std::size_t>(config.log.files));
  for (const auto& entry : fs::directory_iterator(folder.path())) CHECK(entry.file_size() <= config.log.max_bytes);
  CHECK(last_number(config.log.file) == number);
  CHECK_THAT(content(config.log.file), !Contains("level"));
  CHECK(std::regex_search(content(config.log.file),
                          std::regex("^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}\\.[0-9]{3}[-+][0-9:]{5} info: ")));
  if (config.log.files == 3) {
    CHECK(last_number(folder.path() / "live.1.log") < number);
    CHECK(last_number(oldest) < last_number(folder.path() / "live.1.log"));
  }
}

TEST_CASE("A log goes on where it ended") {
  const TemporaryFolder folder;
  config::DaemonConfig config;
  config.log = {config::LogLevel::info, folder.write("live.log", "from before\n"), 10'000, 2};
  daemon::start_logging(config);
  spdlog::info("from now");
  spdlog::shutdown();
  CHECK_THAT(content(config.log.file), Catch::StartsWith("from before\n") && Contains("info: from now\n"));
}

TEST_CASE("A log file that cannot be written is refused at the start, in one line") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  folder.write("file", "");
  fs::create_directory(folder.path() / "folder");
  const std::string pipe = folder.path() / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  const std::string file = GENERATE("file/live.log", "folder", "pipe");
  const std::string path = folder.path() / file;
  ChildProgram program(TISSUED_BINARY, {"--bundle", bundle, "--set", "log.file=" + path, "--tracker-port", "0"});
  CHECK(program.wait() == 2);
  CHECK(program.rest_of_stdout().empty());
  const std::string error = program.rest_of_stderr();
  CHECK(std::count(error.begin(), error.end(), '\n') == 1);
  CHECK_THAT(error, Contains("/log/file: ") && Contains(path));
}

TEST_CASE("tissued logs into its file and says nothing elsewhere, and --check leaves the file alone") {
  const TemporaryFolder folder;
  write_cube_bundle(folder);
  const auto file = folder.write("tissued.json", R"({"format": "tissued-config/1", "bundle": ".",
    "tracker": {"port": 0}, "clients": {"port": 0}, "log": {"level": "info", "file": "live.log"}})");
  ChildProgram check(TISSUED_BINARY, {"--check", "--config", file});
  CHECK(check.wait() == 0);
  CHECK_FALSE(fs::exists(folder.path() / "live.log"));

  ChildProgram program(TISSUED_BINARY, {"--config", file});
  program.read_line();
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  CHECK(program.rest_of_stderr().empty());
  CHECK_THAT(content(folder.path() / "live.log"), Contains("info: cube: 8 nodes") && Contains("info: done: 0 frames"));
}

// As a disk that is full: the kernel writes no file beyond 512 bytes, of which the log's first lines take more.
TEST_CASE("A log that cannot grow holds nothing up") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder);
  const fs::path log = folder.path() / "live.log";
  ChildProgram program("sh", {"-c",
                              "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"",
                              TISSUED_BINARY,
                              "--bundle",
                              bundle,
                              "--tracker-port",
                              "0",
                              "--client-port",
                              "0",
                              "--set",
                              "tracker.address=0.0.0.0",
                              "--set",
                              "clients.address=0.0.0.0",
                              "--set",
                              "clients.prove_addresses=false",
                              "--insecure",
                              "--set",
                              "log.file=" + log.string(),
                              "--log-level",
                              "info"});
  unsigned tracker = 0, clients = 0;
  const std::string line = program.read_line();
  REQUIRE(std::sscanf(line.c_str(), "listening tracker=%u clients=%u", &tracker, &clients) == 2);
  FakeClient client(static_cast<std::uint16_t>(clients));
  CHECK(client.ask<protocol::HelloReply>(protocol::Hello{name_of("test")}).model.view() == "cube");
  program.signal(SIGTERM);
  CHECK(program.wait() == 0);
  CHECK(fs::file_size(log) <= 512);
  CHECK_THAT(content(log), Contains("WHOEVER") && !Contains("; state "));  // the end of what it says at its end
}
