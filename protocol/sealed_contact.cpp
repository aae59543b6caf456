#include "protocol/sealed_contact.hpp"

namespace tissued::protocol {

SealedContact::SealedContact(SealChannel channel, const SecretKey& pre_shared)
    : key_id_(seal_key_id(pre_shared)),
      send_key_(seal_key(pre_shared, channel, SealDirection::to_daemon)),
      receive_key_(seal_key(pre_shared, channel, SealDirection::from_daemon)) {
  begin();
}

// A session of its own for every contact: a challenge recorded during another names that one's.
void SealedContact::begin() {
  draw_random(session_);
  daemon_session_ = {};
  established_ = false;
  window_ = ReplayWindow();
}

std::size_t SealedContact::seal_first_contact(std::span<std::uint8_t> out) {
  return seal_as(SealKind::first_contact, {}, out);
}

std::size_t SealedContact::seal(std::span<const std::uint8_t> payload, std::span<std::uint8_t> out) {
  return established_ ? seal_as(SealKind::data, payload, out) : 0;
}

std::size_t SealedContact::seal_as(SealKind kind, std::span<const std::uint8_t> payload, std::span<std::uint8_t> out) {
  SealHeader header{kind, key_id_, session_, {}, ++counter_};
  if (kind == SealKind::data) header.peer_session = daemon_session_;
  return protocol::seal(send_key_, header, payload, out);
}

SealedContact::Opened SealedContact::open(std::span<const std::uint8_t> datagram) {
  SealHeader header;
  const auto refused = [](SealRefusal refusal) { return Opened{refusal, SealKind::data, {}}; };
  if (const auto refusal = read_seal_header(datagram, header); refusal != SealRefusal::none) return refused(refusal);
  if (header.kind == SealKind::first_contact) return refused(SealRefusal::bad_kind);
  if (header.key_id != key_id_) return refused(SealRefusal::unknown_key);
  if (!unseal(receive_key_, datagram, header, payload_)) return refused(SealRefusal::bad_tag);
  if (header.peer_session != session_) return refused(SealRefusal::wrong_session);
  if (header.kind == SealKind::challenge) {
    take_challenge(header);
    return {SealRefusal::none, SealKind::challenge, {}};
  }
  if (const auto refusal = take_data(header); refusal != SealRefusal::none) return refused(refusal);
  return {SealRefusal::none, SealKind::data, std::span(payload_).first(datagram.size() - kMinSealed)};
}

void SealedContact::take_challenge(const SealHeader& header) {
  if (!established_) {
    daemon_session_ = header.session;
    established_ = true;
  } else if (header.session != daemon_session_) {
    // Not followed at once: this challenge may have been held back from long ago.
    ++lost_contacts_;
    begin();
  }
}

SealRefusal SealedContact::take_data(const SealHeader& header) {
  if (header.session != daemon_session_) return SealRefusal::wrong_session;  // zeros are no sender's
  return refusal_of(window_.take(header.counter));
}

}  // namespace tissued::protocol
