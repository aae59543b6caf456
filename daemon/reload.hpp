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
/// log.level, staleness, clients.lease_s, clients.max_requests_per_s, and what its file of keys holds now.
std::vector<std::string> changes_that_need_a_start(const config::DaemonConfig& running,
                                                   const config::DaemonConfig& wanted);

/// Reads keys and the configuration again when SIGHUP comes, on a thread of its own, while everything goes on. The keys
/// do not wait for a configuration that is sound: a key that was taken out must not be believed because of a fault
/// elsewhere, nor because it was the last one.
class Reload {
 public:
  using Keys = std::vector<config::PreSharedKey>;

  struct Hooks {
    std::function<Keys()> load_keys;  ///< on the thread of its own, as `load` is; null where there are no keys
    std::function<config::DaemonConfig()> load;
    // On the context's thread; `refuse` with a line where one of the above has thrown.
    std::function<void(const Keys&)> use_keys;
    std::function<void(const config::DaemonConfig&)> apply;
    std::function<void(const std::string&)> refuse;
  };

  /// The context must outlive this.
  Reload(boost::asio::io_context& context, Hooks hooks);
  ~Reload();

 private:
  void wait();
  void begin();

  boost::asio::io_context& context_;
  boost::asio::signal_set hangup_;
  Hooks hooks_;
  bool again_ = false;  // another signal has come while it was read
  bool reading_ = false;
  std::thread thread_;
};

}  // namespace tissued::daemon
