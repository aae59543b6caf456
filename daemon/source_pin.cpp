#include "daemon/source_pin.hpp"

#include <utility>

namespace tissued::daemon {

namespace {

using namespace boost::asio::ip;

// On a socket for both families IPv4 comes as IPv6.
address unmapped(const address& from) {
  return from.is_v6() && from.to_v6().is_v4_mapped() ? address(make_address_v4(v4_mapped, from.to_v6())) : from;
}

}  // namespace

SourcePin::SourcePin(const config::TrackerConfig& tracker, const config::StalenessConfig& staleness)
    : peer_(tracker.peer.empty() ? address() : unmapped(make_address(tracker.peer))),
      peer_port_(tracker.peer_port),
      silence_ns_(static_cast<std::uint64_t>(staleness.stale_after.count())) {}

bool SourcePin::is_peer(const Endpoint& from) const {
  return (!names_peer() || unmapped(from.address()) == peer_) && (peer_port_ == 0 || from.port() == peer_port_);
}

bool SourcePin::continues(const Endpoint& from, std::uint64_t now_ns) const {
  return !pinned_ || *pinned_ == from || now_ns >= free_ns();
}

bool SourcePin::note(const Endpoint& from, std::uint64_t now_ns) {
  heard_ns_ = now_ns;
  return std::exchange(pinned_, from) != from;
}

}  // namespace tissued::daemon
