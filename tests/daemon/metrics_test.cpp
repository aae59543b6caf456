#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "daemon/bound_socket.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::daemon;
using namespace std::chrono_literals;
using boost::asio::ip::tcp;

namespace {

// What comes back until the other side hangs up.
std::string talk(std::uint16_t port, const std::string& request) {
  boost::asio::io_context context;
  tcp::socket socket(context);
  socket.connect({boost::asio::ip::address_v4::loopback(), port});
  boost::system::error_code error;
  boost::asio::write(socket, boost::asio::buffer(request), error);
  std::string answer;
  boost::asio::read(socket, boost::asio::dynamic_buffer(answer), error);
  return answer;
}

std::string get(std::uint16_t port, const std::string& target) {
  return talk(port, "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
}

std::string body_of(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

tissued::config::DaemonConfig config_with_metrics() {
  tissued::config::DaemonConfig config = small_config();
  config.metrics.port = 0;
  return config;
}

// The value of the line that begins with these words.
double value_of(const std::string& text, const std::string& name) {
  const std::size_t at = text.find("\n" + name + " ");
  INFO(name);
  REQUIRE(at != std::string::npos);
  return std::stod(text.substr(at + name.size() + 2));
}

}  // namespace

TEST_CASE("Metrics say what the daemon does, as another reader of the format understands them") {
  RunningDaemon daemon(config_with_metrics());
  const std::uint16_t port = daemon.runtime.metrics_port().value();
  FakeClient client(daemon.runtime.client_port());
  client.ask<tissued::protocol::SubscribeReply>(
      tissued::protocol::Subscribe{.what = tissued::protocol::kTargets,
                                   .precision = tissued::protocol::Precision::float32,
                                   .lease_s = 60,
                                   .rate_hz = 0});
  FakeTracker tracker(daemon.runtime.tracker_port());
  for (std::uint32_t number = 1; number <= 20; ++number) {
    tracker.send(frame_with_shift(number, 0.1 * number).frame);
    REQUIRE(eventually([&] { return daemon.count(Count::frames_stepped) == number; }));
  }
  REQUIRE(eventually([&] { return value_of(body_of(get(port, "/metrics")), "tissued_latency_seconds_count") == 20; }));
  const std::string answer = get(port, "/metrics"), text = body_of(answer);
  CHECK_THAT(answer, Catch::StartsWith("HTTP/1.1 200 OK\r\n"));
  CHECK(value_of(text, "tissued_events_total{event=\"frames_stepped\"}") == 20);
  CHECK(value_of(text, "tissued_step_seconds_count") == 20);
  CHECK(value_of(text, "tissued_step_seconds_bucket{le=\"+Inf\"}") == 20);
  CHECK(value_of(text, "tissued_subscribers") == 1);
  CHECK(value_of(text, "tissued_alarm_raised") == 0);
  CHECK(value_of(text, "process_resident_memory_bytes") > 1e6);
  const TemporaryFolder folder;
  const auto file = folder.write("metrics.txt", text);
  // Debian's Python, which python3-prometheus-client is for.
  if (std::system("/usr/bin/python3 -c 'import prometheus_client' 2>/dev/null") != 0) {
    WARN("skipped: no python3-prometheus-client");
    return;
  }
  const std::string read = "/usr/bin/python3 " TISSUED_SOURCE_DIR "/tests/daemon/read_metrics.py " + file.string();
  CHECK(std::system(read.c_str()) == 0);
}

TEST_CASE("Whoever asks for something else over HTTP is told so, and the daemon goes on") {
  RunningDaemon daemon(config_with_metrics());
  const std::uint16_t port = daemon.runtime.metrics_port().value();
  CHECK_THAT(get(port, "/"), Catch::StartsWith("HTTP/1.1 404"));
  CHECK_THAT(get(port, "/metrics/../etc/passwd"), Catch::StartsWith("HTTP/1.1 404"));
  CHECK_THAT(talk(port, "POST /metrics HTTP/1.1\r\nContent-Length: 0\r\n\r\n"), Catch::StartsWith("HTTP/1.1 405"));
  CHECK(body_of(talk(port, "HEAD /metrics HTTP/1.1\r\n\r\n")).empty());
  CHECK(talk(port, "no HTTP at all\r\n\r\n").empty());
  CHECK(talk(port, "GET /metrics HTTP/1.1\r\nX: " + std::string(20000, 'x') + "\r\n\r\n").empty());
  CHECK_THAT(get(port, "/metrics"), Catch::StartsWith("HTTP/1.1 200"));
}

TEST_CASE("Connections that say nothing take neither all places for long nor the daemon's time") {
  RunningDaemon daemon(config_with_metrics());
  const std::uint16_t port = daemon.runtime.metrics_port().value();
  boost::asio::io_context context;
  std::vector<std::unique_ptr<tcp::socket>> silent;
  for (int i = 0; i < 20; ++i) {
    silent.push_back(std::make_unique<tcp::socket>(context));
    silent.back()->connect({boost::asio::ip::address_v4::loopback(), port});
  }
  FakeTracker tracker(daemon.runtime.tracker_port());
  tracker.send(frame_with_shift(1, 0.1).frame);
  CHECK(eventually([&] { return daemon.count(Count::frames_stepped) == 1; }));
  CHECK(eventually([&] { return get(port, "/metrics").starts_with("HTTP/1.1 200"); }, 10s));
}

TEST_CASE("A port for metrics that is taken is named") {
  RunningDaemon daemon(config_with_metrics());
  tissued::config::DaemonConfig config = config_with_metrics();
  config.metrics.port = daemon.runtime.metrics_port();
  FakeSimulator simulator(small_scene());
  CHECK_THROWS_WITH(Runtime(config, simulator),
                    Catch::Contains("metrics") && Catch::Contains(std::to_string(*config.metrics.port)));
}
