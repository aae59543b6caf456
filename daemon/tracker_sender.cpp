#include "daemon/tracker_sender.hpp"

namespace tissued::daemon {

bool TrackerSender::send(const protocol::TrackerFrame& frame) {
  const std::size_t count = protocol::encode_tracker_frame(frame, packets_);
  for (std::size_t i = 0; i < count; ++i) send(packets_[i]);
  return count > 0;
}

void TrackerSender::send(const protocol::TrackerPacket& packet) {
  ++datagrams_;
  undelivered_ += socket_.send(packet.view()) ? 0 : 1;
}

}  // namespace tissued::daemon
