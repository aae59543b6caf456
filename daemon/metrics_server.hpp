#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace tissued::daemon {

/// Answers `GET /metrics` over HTTP on this machine alone, one answer a connection. A few connections at a time, each
/// for a few seconds at most; further ones are hung up on. On the context's thread.
class MetricsServer {
 public:
  /// text(): what is answered, made for every request. Throws BindError.
  MetricsServer(boost::asio::io_context& context, std::uint16_t port, std::function<std::string()> text);
  ~MetricsServer();

  void start();
  void close();
  std::uint16_t port() const { return port_; }

 private:
  class Connection;
  void accept();
  void pause();

  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  std::uint16_t port_ = 0;
  std::function<std::string()> text_;
  std::shared_ptr<int> open_ = std::make_shared<int>(0);  // connections, which may outlive us
};

}  // namespace tissued::daemon
