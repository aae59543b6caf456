#pragma once

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <span>

#include "daemon/counters.hpp"
#include "daemon/peer_table.hpp"
#include "daemon/sealed_port.hpp"
#include "protocol/client_messages.hpp"

namespace tissued::daemon {

/// Encodes messages and sends them to clients, each with its own sequence, sealed where there are keys. Never blocks:
/// what the kernel does not take is counted and lost, as any datagram may be.
class MessageSender {
 public:
  /// The socket, non-blocking, and the others must outlive the sender; sealed: null where there are no keys.
  MessageSender(boost::asio::ip::udp::socket& socket, std::uint32_t session, Counters& counters, SealedPort* sealed)
      : socket_(socket), session_(session), counters_(counters), sealed_(sealed) {}

  template <typename Message>
  void send(Peer& peer, std::uint32_t in_reply_to, const Message& message) {
    const protocol::Envelope envelope{session_, peer.next_sequence++, in_reply_to};
    const std::size_t size = protocol::encode_client_message(envelope, message, buffer_);
    std::span<const std::uint8_t> datagram(buffer_.data(), size);
    if (sealed_ != nullptr && size > 0) datagram = sealed_->seal(peer.contact, datagram);
    send_to(peer.endpoint, datagram);
  }

  /// To somebody who has no place among the clients; not sealed.
  template <typename Message>
  void send_to(const boost::asio::ip::udp::endpoint& to, std::uint32_t in_reply_to, const Message& message) {
    const protocol::Envelope envelope{session_, 0, in_reply_to};
    const std::size_t size = protocol::encode_client_message(envelope, message, buffer_);
    send_to(to, std::span<const std::uint8_t>(buffer_.data(), size));
  }

 private:
  void send_to(const boost::asio::ip::udp::endpoint& to, std::span<const std::uint8_t> datagram) {
    boost::system::error_code error;
    if (!datagram.empty()) socket_.send_to(boost::asio::buffer(datagram.data(), datagram.size()), to, 0, error);
    counters_.add(!datagram.empty() && !error ? Count::datagrams_sent : Count::sends_failed);
  }

  boost::asio::ip::udp::socket& socket_;
  std::uint32_t session_;
  Counters& counters_;
  SealedPort* sealed_;
  std::array<std::uint8_t, protocol::kMaxDatagram> buffer_{};
};

}  // namespace tissued::daemon
