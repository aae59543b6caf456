#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "daemon/endpoint.hpp"

namespace tissued::daemon {

/// A UDP socket bound to any free port and connected to one peer: what a client needs that waits for one thing at a
/// time. One thread may send while another receives.
class UdpSocket {
 public:
  /// Throws std::runtime_error where the host is unknown or the system gives no socket.
  explicit UdpSocket(const Endpoint& peer);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// False where the system took no datagram: no room, or the peer's machine said that nobody listens there.
  bool send(std::span<const std::uint8_t> datagram) noexcept;

  /// The size of the next datagram of the peer (cut off at the buffer's), or nullopt when `deadline_ns` (monotonic
  /// clock) has passed without one. A deadline in the past only takes what is there already.
  std::optional<std::size_t> receive(std::span<std::uint8_t> buffer, std::uint64_t deadline_ns) noexcept;

 private:
  bool wait_readable(std::uint64_t deadline_ns) const noexcept;

  int descriptor_ = -1;
};

}  // namespace tissued::daemon
