#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "protocol/vicon_stream.hpp"

namespace tissued::daemon {

/// What a network does to datagrams; shares are probabilities per datagram.
struct ChannelFaults {
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;         ///< held back by `reorder_hold_ns`, so that later ones overtake it
  std::uint64_t delay_ns = 0;   ///< of every datagram
  std::uint64_t jitter_ns = 0;  ///< added to the delay: uniform between 0 and this
  std::uint64_t reorder_hold_ns = 15'000'000;
};

struct ChannelCounts {
  std::uint64_t in = 0;
  std::uint64_t out = 0;
  std::uint64_t lost = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t held_back = 0;
};

/// A network in virtual time: datagrams go in with the time at which they are sent and come out in the order and at the
/// times at which they arrive. Equal seeds and inputs give equal outputs.
class UnreliableChannel {
 public:
  UnreliableChannel(const ChannelFaults& faults, std::uint64_t seed) : faults_(faults), random_(seed) {}

  void send(const protocol::TrackerPacket& packet, std::uint64_t time_ns);

  /// When the next datagram arrives; nullopt while none is on its way.
  std::optional<std::uint64_t> due_ns() const;
  /// Takes out the next datagram. There must be one.
  protocol::TrackerPacket receive();

  const ChannelCounts& counts() const { return counts_; }

 private:
  struct InFlight {
    std::uint64_t arrival_ns;
    std::uint64_t order;  // of sending, among those that arrive at once
    protocol::TrackerPacket packet;
  };
  static bool arrives_later(const InFlight& a, const InFlight& b);
  void launch(const protocol::TrackerPacket& packet, std::uint64_t time_ns);
  bool happens(double probability);

  ChannelFaults faults_;
  std::mt19937_64 random_;
  std::vector<InFlight> heap_;  // earliest arrival first
  std::uint64_t order_ = 0;
  ChannelCounts counts_;
};

}  // namespace tissued::daemon
