#include "daemon/tracker_sender.hpp"

#include <stdexcept>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kPatience_ns = 2'000'000'000;

}  // namespace

TrackerSender::TrackerSender(const Endpoint& to, const std::optional<protocol::SecretKey>& key)
    : socket_(to, protocol::SealChannel::tracker, key) {
  if (!socket_.meet(monotonic_ns() + kPatience_ns))
    throw std::runtime_error("no answer from " + to_string(to) +
                             ": is tissued running there, with this key among its own?");
}

bool TrackerSender::send(const protocol::TrackerFrame& frame) {
  const std::size_t count = protocol::encode_tracker_frame(frame, packets_);
  for (std::size_t i = 0; i < count; ++i) send(packets_[i]);
  return count > 0;
}

void TrackerSender::send(const protocol::TrackerPacket& packet) {
  ++datagrams_;
  if (socket_.sealed()) socket_.receive(0);  // a daemon that has restarted says so
  undelivered_ += socket_.send(packet.view()) ? 0 : 1;
}

}  // namespace tissued::daemon
