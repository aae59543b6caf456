#include "daemon/bound_socket.hpp"

#include <boost/asio/ip/address.hpp>

namespace tissued::daemon {

namespace {

using boost::asio::ip::udp;

constexpr int kBufferSize = 4 << 20;  // bytes; a second of 19 markers at 1 kHz, and more than most systems grant

}  // namespace

udp::socket bind_udp(boost::asio::io_context& context, const std::string& purpose, const std::string& address,
                     std::uint16_t port) {
  const auto fail = [&](const boost::system::error_code& error) {
    throw BindError("cannot listen for " + purpose + " on " + address + " port " + std::to_string(port) + ": " +
                    error.message());
  };
  boost::system::error_code error;
  const auto ip = boost::asio::ip::make_address(address, error);
  if (error) fail(error);
  const udp::endpoint endpoint(ip, port);
  udp::socket socket(context);
  socket.open(endpoint.protocol(), error);
  if (error) fail(error);
  socket.bind(endpoint, error);
  if (error) fail(error);
  socket.non_blocking(true, error);
  if (error) fail(error);
  // The kernel grants what it allows; less is slower to overflow than the default, not wrong.
  boost::system::error_code ignored;
  socket.set_option(udp::socket::receive_buffer_size(kBufferSize), ignored);
  socket.set_option(udp::socket::send_buffer_size(kBufferSize), ignored);
  return socket;
}

}  // namespace tissued::daemon
