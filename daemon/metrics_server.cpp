#include "daemon/metrics_server.hpp"

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>

#include "daemon/bound_socket.hpp"

namespace tissued::daemon {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;

constexpr int kMostConnections = 8;
constexpr std::size_t kMostRequestBytes = 8192;
constexpr std::chrono::seconds kPatience{5};
constexpr std::chrono::milliseconds kPause{200};

http::response<http::string_body> answer(const http::request<http::empty_body>& request,
                                         const std::function<std::string()>& text) {
  http::response<http::string_body> response;
  response.version(request.version());
  response.keep_alive(false);
  response.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response.result(http::status::method_not_allowed);
    response.set(http::field::allow, "GET, HEAD");
  } else if (request.target() != "/metrics") {
    response.result(http::status::not_found);
    response.body() = "there is /metrics\n";
  } else {
    response.result(http::status::ok);
    response.body() = text();
  }
  response.prepare_payload();  // the length is that of the body, which HEAD does not send
  if (request.method() == http::verb::head) response.body().clear();
  return response;
}

}  // namespace

// Reads one request, writes one answer, and is gone. Keeps itself alive while it waits.
class MetricsServer::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, std::function<std::string()> text, std::shared_ptr<int> open)
      : stream_(std::move(socket)), text_(std::move(text)), open_(std::move(open)) {
    ++*open_;
  }
  ~Connection() { --*open_; }

  void serve() {
    parser_.header_limit(kMostRequestBytes);
    parser_.body_limit(0);
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, parser_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (!error) self->reply();
    });
  }

 private:
  void reply() {
    response_ = answer(parser_.get(), text_);
    stream_.expires_after(kPatience);
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code, std::size_t) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  beast::tcp_stream stream_;
  beast::flat_static_buffer<kMostRequestBytes> buffer_;
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
  std::function<std::string()> text_;
  std::shared_ptr<int> open_;
};

MetricsServer::MetricsServer(boost::asio::io_context& context, std::uint16_t port, std::function<std::string()> text)
    : acceptor_(context), pause_(context), text_(std::move(text)) {
  const tcp::endpoint here(boost::asio::ip::address_v4::loopback(), port);
  boost::system::error_code error;
  acceptor_.open(here.protocol(), error);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.bind(here, error);
  if (!error) acceptor_.listen(kMostConnections, error);
  if (error) {
    throw BindError("cannot listen for metrics on 127.0.0.1 port " + std::to_string(port) + ": " + error.message());
  }
  port_ = acceptor_.local_endpoint().port();
}

MetricsServer::~MetricsServer() = default;

void MetricsServer::start() { accept(); }

void MetricsServer::close() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
}

void MetricsServer::accept() {
  acceptor_.async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == boost::asio::error::operation_aborted) return;
    if (error) return pause();
    if (*open_ < kMostConnections) std::make_shared<Connection>(std::move(socket), text_, open_)->serve();
    accept();
  });
}

// Where the kernel has no room (too many open files) it would say so again at once.
void MetricsServer::pause() {
  pause_.expires_after(kPause);
  pause_.async_wait([this](boost::system::error_code error) {
    if (!error) accept();
  });
}

}  // namespace tissued::daemon
