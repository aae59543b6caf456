#include "protocol/sealed_sessions.hpp"

#include <sodium.h>

#include <algorithm>

#include "protocol/bytes.hpp"

namespace tissued::protocol {

SealedSessions::SealedSessions(SealChannel channel, std::span<const Key> keys, std::uint64_t last_serial)
    : secret_(SecretKey::random()), serial_(last_serial) {
  keys_.reserve(keys.size());
  for (const Key& key : keys) {
    keys_.push_back({seal_key_id(key.pre_shared), key.allowed,
                     seal_key(key.pre_shared, channel, SealDirection::to_daemon),
                     seal_key(key.pre_shared, channel, SealDirection::from_daemon)});
  }
}

SealedSessions::Opened SealedSessions::open(std::span<const std::uint8_t> datagram, const SourceAddress& from) {
  Opened opened;
  SealHeader header;
  opened.refusal = unseal_under_a_key(datagram, header, opened.key);
  if (opened.refusal != SealRefusal::none) return opened;
  opened.kind = header.kind;
  take(header, {opened.key, header.session, from}, datagram.size() - kMinSealed, opened);
  return opened;
}

SealRefusal SealedSessions::unseal_under_a_key(std::span<const std::uint8_t> datagram, SealHeader& header,
                                               std::size_t& key) {
  if (const auto refusal = read_seal_header(datagram, header); refusal != SealRefusal::none) return refusal;
  if (header.kind == SealKind::challenge) return SealRefusal::bad_kind;
  const auto found = find_key(header.key_id);
  if (!found) return SealRefusal::unknown_key;
  key = *found;
  if (!keys_[key].allowed) return SealRefusal::wrong_role;
  return unseal(keys_[key].receive, datagram, header, payload_) ? SealRefusal::none : SealRefusal::bad_tag;
}

// What has been sealed under one of our keys.
void SealedSessions::take(const SealHeader& header, const Sender& sender, std::size_t payload_size, Opened& opened) {
  Place* place = find(sender);
  const SealSession own_session = place != nullptr ? place->own_session : session_for_stranger(sender);
  const bool is_data = header.kind == SealKind::data;
  if (!is_data || header.peer_session != own_session) {
    if (is_data) opened.refusal = SealRefusal::wrong_session;
    opened.challenge = challenge(sender, own_session);
    return;
  }
  if (place == nullptr) place = place_for(sender, own_session);
  if (place == nullptr) {
    opened.refusal = SealRefusal::table_full;
    return;
  }
  opened.refusal = refusal_of(place->window.take(header.counter));
  if (opened.refusal != SealRefusal::none) return;
  place->heard = ++heard_;
  opened.contact = {static_cast<std::size_t>(place - places_.data()), place->serial};
  opened.payload = std::span(payload_).first(payload_size);
}

std::optional<std::size_t> SealedSessions::find_key(const SealKeyId& id) const {
  const auto found = std::find_if(keys_.begin(), keys_.end(), [&](const KeyPair& key) { return key.id == id; });
  if (found == keys_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - keys_.begin());
}

SealedSessions::Place* SealedSessions::find(const Sender& sender) {
  const auto found = std::find_if(places_.begin(), places_.end(),
                                  [&](const Place& place) { return place.serial != 0 && place.sender == sender; });
  return found != places_.end() ? &*found : nullptr;
}

// For a contact that has answered our challenge; nullptr where every place is kept.
SealedSessions::Place* SealedSessions::place_for(const Sender& sender, const SealSession& own_session) {
  // A free place was never heard, which is before all others.
  const auto by_silence = [](const Place& a, const Place& b) { return a.kept != b.kept ? b.kept : a.heard < b.heard; };
  Place& place = *std::min_element(places_.begin(), places_.end(), by_silence);
  if (place.kept) return nullptr;
  if (place.serial != 0) {
    ++evicted_;
    ++generation_;
  }
  place = Place{};
  place.serial = ++serial_;
  place.sender = sender;
  place.own_session = own_session;
  return &place;
}

SealSession SealedSessions::session_for_stranger(const Sender& sender) const {
  std::array<std::uint8_t, 8 + 16 + 16 + 2 + 8> message{};
  ByteWriter writer(message);
  writer.bytes(keys_[sender.key].id);
  writer.bytes(sender.session);
  writer.bytes(sender.address.ip);
  writer.u16(sender.address.port);
  writer.u64(generation_);
  SealSession session{};
  crypto_generichash(session.data(), session.size(), message.data(), message.size(), secret_.bytes().data(),
                     secret_.bytes().size());
  return session;
}

std::span<const std::uint8_t> SealedSessions::challenge(const Sender& sender, const SealSession& own_session) {
  return std::span(challenge_).first(seal_as(SealKind::challenge, sender, own_session, {}, challenge_));
}

// One counter for all contacts: no nonce comes twice, whatever is hashed to which session.
std::size_t SealedSessions::seal_as(SealKind kind, const Sender& to, const SealSession& own_session,
                                    std::span<const std::uint8_t> payload, std::span<std::uint8_t> out) {
  const KeyPair& key = keys_[to.key];
  return protocol::seal(key.send, {kind, key.id, own_session, to.session, ++counter_}, payload, out);
}

std::size_t SealedSessions::seal(Contact contact, std::span<const std::uint8_t> payload, std::span<std::uint8_t> out) {
  if (!has_place(contact)) return 0;
  const Place& place = places_[contact.place];
  return seal_as(SealKind::data, place.sender, place.own_session, payload, out);
}

void SealedSessions::keep(Contact contact, bool kept) {
  if (has_place(contact)) places_[contact.place].kept = kept;
}

bool SealedSessions::has_place(Contact contact) const {
  return contact.serial != 0 && contact.place < kPlaces && places_[contact.place].serial == contact.serial;
}

}  // namespace tissued::protocol
