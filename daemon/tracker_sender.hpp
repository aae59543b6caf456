#pragma once

#include <array>
#include <cstdint>

#include "daemon/contact_socket.hpp"
#include "protocol/vicon_stream.hpp"

namespace tissued::daemon {

/// Sends tracker frames as a tracking system does: datagrams of at most 1024 bytes, whether somebody listens or not.
/// With a key they are sealed, which no tracking system does; then the daemon must be there.
class TrackerSender {
 public:
  /// Throws std::runtime_error where there is no such host, or none that knows the key.
  explicit TrackerSender(const Endpoint& to, const std::optional<protocol::SecretKey>& key = std::nullopt);

  /// False, and nothing sent, where the frame cannot go on the wire: a value that no decoder would take.
  bool send(const protocol::TrackerFrame& frame);
  void send(const protocol::TrackerPacket& packet);

  std::uint64_t datagrams() const { return datagrams_; }  ///< given to the system
  std::uint64_t undelivered() const {
    return undelivered_;
  }  ///< not taken by the system: nobody listens, or no room; or no contact

 private:
  ContactSocket socket_;
  std::array<protocol::TrackerPacket, protocol::kMaxPacketsPerFrame> packets_;
  std::uint64_t datagrams_ = 0;
  std::uint64_t undelivered_ = 0;
};

}  // namespace tissued::daemon
