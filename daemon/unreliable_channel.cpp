#include "daemon/unreliable_channel.hpp"

#include <algorithm>
#include <tuple>

namespace tissued::daemon {

bool UnreliableChannel::arrives_later(const InFlight& a, const InFlight& b) {
  return std::tie(a.arrival_ns, a.order) > std::tie(b.arrival_ns, b.order);
}

// Draws even for 0, so that changing one fault leaves the others' dice alone.
bool UnreliableChannel::happens(double probability) {
  return std::uniform_real_distribution<double>(0.0, 1.0)(random_) < probability;
}

void UnreliableChannel::send(const protocol::TrackerPacket& packet, std::uint64_t time_ns) {
  ++counts_.in;
  const bool lost = happens(faults_.loss);
  const bool twice = happens(faults_.duplicate);
  if (lost) {
    ++counts_.lost;
    return;
  }
  launch(packet, time_ns);
  if (!twice) return;
  ++counts_.duplicated;
  launch(packet, time_ns);
}

void UnreliableChannel::launch(const protocol::TrackerPacket& packet, std::uint64_t time_ns) {
  const bool held = happens(faults_.reorder);
  counts_.held_back += held ? 1 : 0;
  const std::uint64_t jitter = std::uniform_int_distribution<std::uint64_t>(0, faults_.jitter_ns)(random_);
  const std::uint64_t arrival = time_ns + faults_.delay_ns + jitter + (held ? faults_.reorder_hold_ns : 0);
  heap_.push_back({arrival, order_++, packet});
  std::push_heap(heap_.begin(), heap_.end(), arrives_later);
}

std::optional<std::uint64_t> UnreliableChannel::due_ns() const {
  if (heap_.empty()) return std::nullopt;
  return heap_.front().arrival_ns;
}

protocol::TrackerPacket UnreliableChannel::receive() {
  std::pop_heap(heap_.begin(), heap_.end(), arrives_later);
  const protocol::TrackerPacket packet = heap_.back().packet;
  heap_.pop_back();
  ++counts_.out;
  return packet;
}

}  // namespace tissued::daemon
