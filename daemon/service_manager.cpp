#include "daemon/service_manager.hpp"

#include <sys/socket.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "daemon/alarm_report.hpp"
#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr std::uint64_t kShortestPeriod_ns = 10'000'000;
constexpr std::uint64_t kLongestPeriod_ns = 5 * kSecond_ns;  // a status is not to be older
constexpr std::uint64_t kLongStep_ns = kSecond_ns;           // that a status mentions

// A path, or @ and a name of Linux's abstract namespace, which ends where its size says.
socklen_t read_address(const std::string& text, sockaddr_un& address) {
  const bool abstract = text.starts_with('@');
  const std::size_t size = text.size() + (abstract ? 0 : 1);
  if ((!abstract && !text.starts_with('/')) || text.size() < 2 || size > sizeof address.sun_path) {
    throw std::runtime_error("NOTIFY_SOCKET: \"" + text + "\" is not an absolute path, nor @ and a name, of at most " +
                             std::to_string(sizeof address.sun_path - 1) + " characters");
  }
  address.sun_family = AF_UNIX;
  std::copy(text.begin(), text.end(), address.sun_path);
  if (abstract) address.sun_path[0] = '\0';
  return static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + size);
}

std::uint64_t read_watchdog_ns() {
  std::uint64_t period_us = 0;
  const int wanted = ::sd_watchdog_enabled(0, &period_us);
  if (wanted < 0) throw std::runtime_error(std::string("WATCHDOG_USEC: ") + std::strerror(-wanted));
  constexpr std::uint64_t kLongest_us = 1'000'000'000'000'000;  // 31 years, which still are a number of ns
  return wanted == 0 ? 0 : 1000 * std::min(period_us, kLongest_us);
}

std::uint64_t period_of(std::uint64_t watchdog_ns) {
  return watchdog_ns == 0 ? kLongestPeriod_ns : std::clamp(watchdog_ns / 2, kShortestPeriod_ns, kLongestPeriod_ns);
}

std::string status_line(const protocol::Status& status, std::uint64_t in_step_ns) {
  char text[80];
  std::snprintf(text, sizeof text, "%.0f frames/s, %s, alarm ", status.step_rate_hz, to_string(status.validity));
  std::string line = text + alarm_text(status.alarm);
  if (in_step_ns > kLongStep_ns) {
    std::snprintf(text, sizeof text, ", in one step for %.1f s", 1e-9 * static_cast<double>(in_step_ns));
    line += text;
  }
  return line;
}

}  // namespace

bool ServiceManager::listens() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  return address != nullptr && *address != '\0';
}

ServiceManager::ServiceManager(boost::asio::io_context& context, const SimulationThread& simulation,
                               std::function<protocol::Status(std::uint64_t)> status)
    : simulation_(simulation),
      status_(std::move(status)),
      timer_(context),
      watchdog_ns_(read_watchdog_ns()),
      period_ns_(period_of(watchdog_ns_)),
      address_size_(read_address(std::getenv("NOTIFY_SOCKET"), address_)),
      socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) throw std::system_error(errno, std::generic_category(), "NOTIFY_SOCKET");
}

ServiceManager::~ServiceManager() { ::close(socket_); }

void ServiceManager::start() { tell(); }

void ServiceManager::stop() {
  timer_.cancel();
  send("STOPPING=1\n");
}

void ServiceManager::tell() {
  const std::uint64_t began_ns = simulation_.step_began_ns();
  const std::uint64_t now_ns = monotonic_ns();
  const std::uint64_t in_step_ns = began_ns == 0 || began_ns > now_ns ? 0 : now_ns - began_ns;
  std::string message = "STATUS=" + status_line(status_(now_ns), in_step_ns) + "\n";
  if (!told_ready_) message += "READY=1\n";
  if (watchdog_ns_ > 0 && in_step_ns <= watchdog_ns_) message += "WATCHDOG=1\n";
  if (send(message)) told_ready_ = true;
  timer_.expires_after(std::chrono::nanoseconds(period_ns_));
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) tell();
  });
}

// libsystemd's sd_notify() would wait until the manager has taken what was sent before.
bool ServiceManager::send(const std::string& message) noexcept {
  return ::sendto(socket_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                  reinterpret_cast<const sockaddr*>(&address_), address_size_) >= 0;
}

}  // namespace tissued::daemon
