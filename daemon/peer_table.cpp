#include "daemon/peer_table.hpp"

#include <algorithm>

namespace tissued::daemon {

using boost::asio::ip::udp;

Peer* PeerTable::find(const udp::endpoint& endpoint) {
  const auto found = std::find_if(peers_.begin(), peers_.end(),
                                  [&](const Peer& peer) { return peer.heard_ns != 0 && peer.endpoint == endpoint; });
  return found != peers_.end() ? &*found : nullptr;
}

Peer& PeerTable::hear(const udp::endpoint& endpoint, std::uint64_t now_ns) {
  Peer* peer = find(endpoint);
  if (peer == nullptr) {
    // At least kVisitors places are without a subscription; a free one was heard at 0, before all others.
    const auto silence = [](const Peer& a, const Peer& b) {
      return a.grant.has_value() != b.grant.has_value() ? b.grant.has_value() : a.heard_ns < b.heard_ns;
    };
    peer = &*std::min_element(peers_.begin(), peers_.end(), silence);
    first_sequence_ = std::max(first_sequence_, peer->next_sequence);
    *peer = Peer{};
    peer->endpoint = endpoint;
    peer->next_sequence = first_sequence_;
  }
  peer->heard_ns = now_ns;
  return *peer;
}

bool PeerTable::subscribe(Peer& peer, const Grant& grant) {
  if (!peer.grant) {
    if (subscribers_ == max_subscribers_) return false;
    ++subscribers_;
  }
  peer.grant = grant;
  return true;
}

void PeerTable::unsubscribe(Peer& peer) {
  if (!peer.grant) return;
  peer.grant.reset();
  --subscribers_;
}

}  // namespace tissued::daemon
