#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/replay_window.hpp"
#include "protocol/sealed_datagram.hpp"
#include "protocol/source_address.hpp"

namespace tissued::protocol {

// The daemon's end: many contacts under many keys, on one channel. What it accepts was sealed since the daemon started,
// by the owner of a key, for this contact, by somebody who receives at the address it came from; and is accepted once.
//
// Toward every contact the daemon has another session, a keyed hash of the contact: so a challenge can be answered
// without anything being remembered, and only a contact that has answered one takes a place in the table. Its place
// holds the counters it has used. Where the table is full, the contact that has been silent for longest and is not kept
// loses its place, and from then on every contact that has no place is hashed to another session than before: what the
// forgotten one had sent cannot be taken twice. It is challenged, as a stranger is, when it sends again.
// Not copied, nor used after a fork: two that count alike would seal two datagrams under one nonce.
class SealedSessions {
 public:
  static constexpr std::size_t kPlaces = 64;

  struct Key {
    SecretKey pre_shared;
    bool allowed = true;  // its role is this channel's
  };

  // One contact for as long as it has its place.
  struct Contact {
    std::size_t place = 0;
    std::uint64_t serial = 0;  // 0: nobody

    friend bool operator==(const Contact&, const Contact&) = default;
  };

  struct Opened {
    SealRefusal refusal = SealRefusal::none;
    SealKind kind = SealKind::data;           // where nothing is refused
    std::size_t key = 0;                      // index of the key, where one is named that is known
    Contact contact;                          // of data that were not refused
    std::span<const std::uint8_t> payload;    // of data that were not refused; good until the next call
    std::span<const std::uint8_t> challenge;  // to be sent back; never longer than the question; good until then, too
  };

  // Throws as draw_random does.
  SealedSessions(SealChannel channel, std::span<const Key> keys, std::uint64_t last_serial = 0);
  SealedSessions(const SealedSessions&) = delete;
  // Of the newest contact: where keys are exchanged, no serial may come to mean somebody else.
  std::uint64_t last_serial() const { return serial_; }
  SealedSessions& operator=(const SealedSessions&) = delete;

  Opened open(std::span<const std::uint8_t> datagram, const SourceAddress& from);

  // Writes one datagram and returns its size; 0 where the contact has lost its place, the payload is longer than
  // kMaxDatagram, or `out` is too small.
  std::size_t seal(Contact contact, std::span<const std::uint8_t> payload, std::span<std::uint8_t> out);

  // Whether the contact keeps its place however long it is silent, e.g. while it has a subscription. A new contact
  // begins without. Nothing happens where it has lost its place.
  void keep(Contact contact, bool kept);

  bool has_place(Contact contact) const;
  // Contacts that lost their place to another.
  std::uint64_t evicted() const { return evicted_; }

 private:
  struct KeyPair {
    SealKeyId id;
    bool allowed;
    SecretKey receive;
    SecretKey send;
  };

  // Who sends, by what the tag and the source say.
  struct Sender {
    std::size_t key = 0;
    SealSession session{};
    SourceAddress address;

    friend bool operator==(const Sender&, const Sender&) = default;
  };

  struct Place {
    std::uint64_t serial = 0;  // 0: free
    Sender sender;
    SealSession own_session{};  // ours toward it
    std::uint64_t heard = 0;    // 0: never
    bool kept = false;
    ReplayWindow window;
  };

  SealRefusal unseal_under_a_key(std::span<const std::uint8_t> datagram, SealHeader& header, std::size_t& key);
  std::optional<std::size_t> find_key(const SealKeyId& id) const;
  Place* find(const Sender& sender);
  Place* place_for(const Sender& sender, const SealSession& own_session);
  SealSession session_for_stranger(const Sender& sender) const;
  void take(const SealHeader& header, const Sender& sender, std::size_t payload_size, Opened& opened);
  std::span<const std::uint8_t> challenge(const Sender& sender, const SealSession& own_session);
  std::size_t seal_as(SealKind kind, const Sender& to, const SealSession& own_session,
                      std::span<const std::uint8_t> payload, std::span<std::uint8_t> out);

  std::vector<KeyPair> keys_;
  SecretKey secret_;              // of the sessions toward contacts
  std::uint64_t generation_ = 0;  // of the sessions toward contacts that have no place
  std::uint64_t counter_ = 0;     // of the datagram sealed last, whoever it was for
  std::uint64_t serial_ = 0;      // of the newest contact
  std::uint64_t heard_ = 0;       // datagrams taken
  std::uint64_t evicted_ = 0;
  std::array<Place, kPlaces> places_{};
  std::array<std::uint8_t, kMaxDatagram> payload_{};
  std::array<std::uint8_t, kMinSealed> challenge_{};
};

}  // namespace tissued::protocol
