#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "daemon/udp_socket.hpp"
#include "protocol/sealed_contact.hpp"

namespace tissued::daemon {

/// A UdpSocket to tissued that seals what it sends and opens what it receives where there is a key, and passes
/// everything as it is where there is none. Not for two threads.
class ContactSocket {
 public:
  /// Throws as UdpSocket does.
  ContactSocket(const Endpoint& daemon, protocol::SealChannel channel, const std::optional<protocol::SecretKey>& key);

  bool sealed() const { return contact_.has_value(); }
  /// Waits until what is sent can be opened there; false where `deadline_ns` (monotonic clock) passes before.
  bool meet(std::uint64_t deadline_ns) noexcept;

  /// False where the system took no datagram, or while there is no contact: then contact is sought.
  bool send(std::span<const std::uint8_t> datagram) noexcept;
  /// The next datagram of the peer, good until the next call, or nothing at `deadline_ns`; see UdpSocket::receive.
  std::optional<std::span<const std::uint8_t>> receive(std::uint64_t deadline_ns) noexcept;

  std::uint64_t refused() const { return refused_; }  ///< datagrams that could not be opened

 private:
  void seek_contact() noexcept;

  UdpSocket socket_;
  std::optional<protocol::SealedContact> contact_;
  std::uint64_t sought_ns_ = 0;
  std::uint64_t refused_ = 0;
  std::array<std::uint8_t, protocol::kMaxSealed> sealed_{};
  std::array<std::uint8_t, protocol::kMaxSealed + 1> buffer_{};  // one more, so that a datagram too long is seen to be
};

}  // namespace tissued::daemon
