#pragma once

#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <optional>

#include "config/daemon_config.hpp"

namespace tissued::daemon {

/// Whose tracker datagrams are taken. What is not sealed must come from the configured peer, where there is one; and
/// all must come from the address and port that the stream began with, until it has been silent for so long that the
/// answer is stale: a second tracker, started by mistake, cannot mix its frames with the first one's.
class SourcePin {
 public:
  using Endpoint = boost::asio::ip::udp::endpoint;

  SourcePin(const config::TrackerConfig& tracker, const config::StalenessConfig& staleness);

  void apply(const config::StalenessConfig& staleness) {
    silence_ns_ = static_cast<std::uint64_t>(staleness.stale_after.count());
  }
  bool names_peer() const { return !peer_.is_unspecified(); }
  /// Whether that is the configured peer, or any would do.
  bool is_peer(const Endpoint& from) const;
  /// Whether the stream may go on from there. now_ns: monotonic clock.
  bool continues(const Endpoint& from, std::uint64_t now_ns) const;
  /// A good datagram has come from there. Whether it is another source than before.
  bool note(const Endpoint& from, std::uint64_t now_ns);
  /// When the stream will have been silent for so long that anybody's may begin.
  std::uint64_t free_ns() const { return heard_ns_ + silence_ns_; }

 private:
  boost::asio::ip::address peer_;  // unspecified: any
  std::uint16_t peer_port_;        // 0: any
  std::uint64_t silence_ns_;
  std::optional<Endpoint> pinned_;
  std::uint64_t heard_ns_ = 0;
};

}  // namespace tissued::daemon
