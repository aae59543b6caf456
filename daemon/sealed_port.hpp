#pragma once

#include <array>
#include <boost/asio/ip/udp.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "config/key_file.hpp"
#include "daemon/counters.hpp"
#include "protocol/sealed_sessions.hpp"

namespace tissued::daemon {

/// Stands before a port whose peers have keys: opens what they sealed, answers those who are not known yet, refuses and
/// counts everything else.
class SealedPort {
 public:
  using Contact = protocol::SealedSessions::Contact;

  struct Opened {
    Contact contact;
    std::span<const std::uint8_t> payload;  ///< good until the next call
  };

  /// The socket, non-blocking, and the counters must outlive this. Keys whose role is another channel's are known, and
  /// refused as such.
  SealedPort(boost::asio::ip::udp::socket& socket, protocol::SealChannel channel,
             std::span<const config::PreSharedKey> keys, Counters& counters);

  /// Null where there are no keys.
  static std::unique_ptr<SealedPort> make(boost::asio::ip::udp::socket& socket, protocol::SealChannel channel,
                                          std::span<const config::PreSharedKey> keys, Counters& counters) {
    return keys.empty() ? nullptr : std::make_unique<SealedPort>(socket, channel, keys, counters);
  }

  /// What an owner of a key says, or nothing. Sends a challenge where one is due, never longer than the question.
  std::optional<Opened> open(std::span<const std::uint8_t> datagram, const boost::asio::ip::udp::endpoint& from);

  /// `payload` as it goes out to `contact`, good until the next call; empty where the contact has lost its place.
  std::span<const std::uint8_t> seal(Contact contact, std::span<const std::uint8_t> payload);

  /// See protocol::SealedSessions::keep.
  void keep(Contact contact, bool kept) { sessions_->keep(contact, kept); }

  /// Where these are others than those so far, all contacts are void, and begin anew where they still may.
  void use(std::span<const config::PreSharedKey> keys);

 private:
  boost::asio::ip::udp::socket& socket_;
  Counters& counters_;
  protocol::SealChannel channel_;
  std::vector<config::PreSharedKey> keys_;
  std::unique_ptr<protocol::SealedSessions> sessions_;
  std::array<std::uint8_t, protocol::kMaxSealed> buffer_{};
};

}  // namespace tissued::daemon
