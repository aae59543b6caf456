#pragma once

#include <algorithm>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/client_messages.hpp"
#include "protocol/sealed_sessions.hpp"
#include "protocol/sequence_gate.hpp"

namespace tissued::daemon {

/// What a client has subscribed to. All times are of the monotonic clock.
struct Grant {
  std::uint8_t what = 0;                                         ///< protocol::What bits
  protocol::Precision precision = protocol::Precision::float32;  ///< of mesh positions
  std::uint64_t period_ns = 0;                                   ///< 0: after every tracker frame
  std::uint64_t expires_ns = 0;
  std::uint64_t due_ns = 0;        ///< the next answer goes out from then on
  std::uint64_t last_sent_ns = 0;  ///< of targets or mesh
  std::uint64_t status_due_ns = 0;
  unsigned meshes_due = 0;  ///< so far; under overload only some of them are sent

  bool streams_like(const Grant& other) const {
    return what == other.what && precision == other.precision && period_ns == other.period_ns;
  }
};

/// A mesh that a client waits for.
struct MeshWish {
  std::uint32_t in_reply_to = 0;
  protocol::Precision precision = protocol::Precision::float32;
};

/// So many a second, and at once, and no more.
class RequestAllowance {
 public:
  bool take(double per_second, std::uint64_t now_ns) {
    left_ = std::min(per_second, left_ + per_second * 1e-9 * static_cast<double>(now_ns - at_ns_));
    at_ns_ = now_ns;
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  double left_ = 0.0;
  std::uint64_t at_ns_ = 0;  // long ago: full
};

/// A client that has been heard of: one address and port.
struct Peer {
  boost::asio::ip::udp::endpoint endpoint;
  std::uint32_t next_sequence = 1;            ///< of the datagram sent to it next
  std::uint64_t heard_ns = 0;                 ///< 0: this place in the table is free
  protocol::SealedSessions::Contact contact;  ///< where there are keys
  RequestAllowance allowance;
  protocol::SequenceGate gate;  ///< of its requests
  std::optional<Grant> grant;
  std::optional<MeshWish> mesh_wish;
};

/// The clients that have been heard of, in a table of fixed size. A newcomer takes a free place, or that of the client
/// without a subscription that has been silent for longest. Sequence numbers to one client never go back, even if it
/// has been forgotten in between.
class PeerTable {
 public:
  static constexpr std::size_t kVisitors = 64;  ///< places beyond those of subscribers

  explicit PeerTable(std::size_t max_subscribers)
      : peers_(max_subscribers + kVisitors), max_subscribers_(max_subscribers) {}

  /// The client at `endpoint`, which was heard just now. The reference is good until the next call.
  Peer& hear(const boost::asio::ip::udp::endpoint& endpoint, std::uint64_t now_ns);
  /// nullptr where it is not in the table (any more).
  Peer* find(const boost::asio::ip::udp::endpoint& endpoint);

  /// Grants the subscription, in place of an earlier one; false where there is no room for another subscriber.
  bool subscribe(Peer& peer, const Grant& grant);
  void unsubscribe(Peer& peer);
  std::size_t subscriber_count() const { return subscribers_; }

  /// All places, free ones too.
  std::span<Peer> all() { return peers_; }

 private:
  std::vector<Peer> peers_;
  std::size_t max_subscribers_;
  std::size_t subscribers_ = 0;
  std::uint32_t first_sequence_ = 1;  // beyond all that was sent to clients forgotten since
};

}  // namespace tissued::daemon
