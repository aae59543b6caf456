#pragma once

#include <boost/asio/ip/udp.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace tissued::daemon {

/// A datagram as the kernel handed it over.
struct ReceivedDatagram {
  std::size_t size = 0;          ///< bytes, at most those of the buffer; what was longer is cut off
  std::uint64_t receive_ns = 0;  ///< monotonic clock, when it reached the socket
  boost::asio::ip::udp::endpoint from{};
  std::optional<std::uint32_t> drops{};  ///< datagrams that the socket's full buffer has cost so far, modulo 2^32
};

/// Has the kernel stamp datagrams on arrival and count those it drops, where it can.
void stamp_arrivals(int socket) noexcept;

/// The next datagram that waits in `socket`; nullopt where there is none. Never blocks.
std::optional<ReceivedDatagram> receive_stamped(int socket, std::span<std::uint8_t> buffer) noexcept;

}  // namespace tissued::daemon
