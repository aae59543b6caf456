#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace tissued::daemon {

/// An address or port that cannot be listened on. what() is one line that names purpose, address and reason.
class BindError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A non-blocking UDP socket bound to `address` (IPv4 or IPv6, in digits) and `port` (0: any free one), with room for
/// bursts. purpose: "tracker" or "clients", for the message. Throws BindError.
boost::asio::ip::udp::socket bind_udp(boost::asio::io_context& context, const std::string& purpose,
                                      const std::string& address, std::uint16_t port);

}  // namespace tissued::daemon
