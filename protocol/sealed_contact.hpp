#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/replay_window.hpp"
#include "protocol/sealed_datagram.hpp"

namespace tissued::protocol {

// The end that asks: a client, or whoever sends tracker datagrams. Knows one key and one daemon. What it accepts was
// sealed by that daemon since this contact began, and is accepted once.
//
// Contact: send first contacts until established(), then seal(). A daemon that does not know the contact any more, for
// it has restarted or had no room, says so by another challenge; open() then begins anew, and established() is false.
// Not copied, nor used after a fork: two that count alike would seal two datagrams under one nonce.
class SealedContact {
 public:
  struct Opened {
    SealRefusal refusal = SealRefusal::none;
    SealKind kind = SealKind::data;         // where nothing is refused
    std::span<const std::uint8_t> payload;  // of data; good until the next call
  };

  // Throws as draw_random does.
  SealedContact(SealChannel channel, const SecretKey& pre_shared);
  SealedContact(const SealedContact&) = delete;
  SealedContact& operator=(const SealedContact&) = delete;

  bool established() const { return established_; }
  // Times an established contact was found lost.
  std::uint64_t lost_contacts() const { return lost_contacts_; }

  // Each writes one datagram and returns its size, 0 where `out` is too small; seal also where no contact is
  // established or the payload is longer than kMaxDatagram.
  std::size_t seal_first_contact(std::span<std::uint8_t> out);
  std::size_t seal(std::span<const std::uint8_t> payload, std::span<std::uint8_t> out);

  Opened open(std::span<const std::uint8_t> datagram);

 private:
  void begin();
  void take_challenge(const SealHeader& header);
  SealRefusal take_data(const SealHeader& header);
  std::size_t seal_as(SealKind kind, std::span<const std::uint8_t> payload, std::span<std::uint8_t> out);

  SealKeyId key_id_;
  SecretKey send_key_;
  SecretKey receive_key_;
  SealSession session_{};
  SealSession daemon_session_{};  // zeros until established
  bool established_ = false;
  std::uint64_t counter_ = 0;  // of the datagram sealed last
  std::uint64_t lost_contacts_ = 0;
  ReplayWindow window_;
  std::array<std::uint8_t, kMaxDatagram> payload_{};
};

}  // namespace tissued::protocol
