#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>

#include "daemon/counters.hpp"
#include "daemon/peer_table.hpp"
#include "protocol/client_messages.hpp"

namespace tissued::daemon {

/// Encodes messages and sends them to clients, each with its own sequence. Never blocks: what the kernel does not take
/// is counted and lost, as any datagram may be.
class MessageSender {
 public:
  /// The socket, non-blocking, and the counters must outlive the sender.
  MessageSender(boost::asio::ip::udp::socket& socket, std::uint32_t session, Counters& counters)
      : socket_(socket), session_(session), counters_(counters) {}

  template <typename Message>
  void send(Peer& peer, std::uint32_t in_reply_to, const Message& message) {
    const protocol::Envelope envelope{session_, peer.next_sequence++, in_reply_to};
    const std::size_t size = protocol::encode_client_message(envelope, message, buffer_);
    boost::system::error_code error;
    if (size > 0) socket_.send_to(boost::asio::buffer(buffer_.data(), size), peer.endpoint, 0, error);
    counters_.add(size > 0 && !error ? Count::datagrams_sent : Count::sends_failed);
  }

 private:
  boost::asio::ip::udp::socket& socket_;
  std::uint32_t session_;
  Counters& counters_;
  std::array<std::uint8_t, protocol::kMaxDatagram> buffer_{};
};

}  // namespace tissued::daemon
