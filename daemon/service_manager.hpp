#pragma once

#include <sys/un.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <string>

#include "daemon/simulation_thread.hpp"
#include "protocol/status_messages.hpp"

namespace tissued::daemon {

/// Tells the service manager that started the process (systemd, by the datagrams of sd_notify(3)) that the daemon is
/// ready, in a line now and then how it is doing, that it is alive, and that it stops. Alive: the context's thread
/// turns, and the simulation is not in one step for longer than the manager's watchdog waits. What the manager has no
/// room for is lost, and said again when the time for the next has come. On the context's thread.
class ServiceManager {
 public:
  /// Whether there is one that wants to be told: NOTIFY_SOCKET.
  static bool listens();

  /// status(): at a time of the monotonic clock in ns. simulation must outlive this. Throws std::runtime_error where
  /// NOTIFY_SOCKET or WATCHDOG_USEC is malformed, std::system_error where the process has no descriptor left.
  ServiceManager(boost::asio::io_context& context, const SimulationThread& simulation,
                 std::function<protocol::Status(std::uint64_t)> status);
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// Ready: sockets are bound and there is an answer.
  void start();
  void stop();

 private:
  void tell();
  bool send(const std::string& message) noexcept;

  const SimulationThread& simulation_;
  std::function<protocol::Status(std::uint64_t)> status_;
  boost::asio::steady_timer timer_;
  std::uint64_t watchdog_ns_;  // 0: none
  std::uint64_t period_ns_;    // from one message to the next
  bool told_ready_ = false;
  sockaddr_un address_{};
  socklen_t address_size_ = 0;
  int socket_ = -1;
};

}  // namespace tissued::daemon
