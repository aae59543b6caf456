#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "config/daemon_config.hpp"

namespace tissued::daemon {

/// Keys of the configuration that differ and that a running daemon does not take on: JSON pointers. It takes on
/// log.level, staleness, clients.lease_s, clients.max_requests_per_s, and other keys in place of those it has.
std::vector<std::string> changes_that_need_a_start(const config::DaemonConfig& running,
                                                   const config::DaemonConfig& wanted);

/// Reads the configuration again when SIGHUP comes, on a thread of its own, while everything goes on.
class Reload {
 public:
  using Load = std::function<config::DaemonConfig()>;
  using Apply = std::function<void(const config::DaemonConfig&)>;
  using Refuse = std::function<void(const std::string&)>;

  /// apply and refuse are called on the context's thread: refuse, with why, where `load` has thrown. The context must
  /// outlive this.
  Reload(boost::asio::io_context& context, Load load, Apply apply, Refuse refuse);
  ~Reload();

 private:
  void wait();
  void begin();

  boost::asio::io_context& context_;
  boost::asio::signal_set hangup_;
  Load load_;
  Apply apply_;
  Refuse refuse_;
  bool again_ = false;  // another signal has come while it was read
  bool reading_ = false;
  std::thread thread_;
};

}  // namespace tissued::daemon
