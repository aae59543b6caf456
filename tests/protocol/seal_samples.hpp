#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "protocol/sealed_contact.hpp"
#include "protocol/sealed_sessions.hpp"

namespace tissued::tests {

using Bytes = std::vector<std::uint8_t>;

// `size` bytes: first, first + 1, ...
inline Bytes counting_bytes(std::size_t size, int first) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(first));
  return bytes;
}

// The key of 32 bytes first, first + 1, ...; that of 0 is the key of the example in protocol/README.md.
inline protocol::SecretKey sample_key(int first = 0) {
  const Bytes bytes = counting_bytes(protocol::kSecretKeySize, first);
  return protocol::SecretKey(std::span<const std::uint8_t, protocol::kSecretKeySize>(bytes));
}

inline protocol::SealSession sample_session(int first) {
  protocol::SealSession session{};
  std::iota(session.begin(), session.end(), static_cast<std::uint8_t>(first));
  return session;
}

inline protocol::SourceAddress sample_address(int host, std::uint16_t port = 40000) {
  return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 192, 168, 1, static_cast<std::uint8_t>(host)}, port};
}

inline Bytes first_contact(protocol::SealedContact& contact) {
  Bytes datagram(protocol::kMaxSealed);
  datagram.resize(contact.seal_first_contact(datagram));
  return datagram;
}

inline Bytes sealed(protocol::SealedContact& contact, std::span<const std::uint8_t> payload) {
  Bytes datagram(protocol::kMaxSealed);
  datagram.resize(contact.seal(payload, datagram));
  return datagram;
}

inline Bytes sealed(protocol::SealedSessions& sessions, protocol::SealedSessions::Contact contact,
                    std::span<const std::uint8_t> payload) {
  Bytes datagram(protocol::kMaxSealed);
  datagram.resize(sessions.seal(contact, payload, datagram));
  return datagram;
}

// The daemon's challenge to the contact's question.
inline Bytes challenge(protocol::SealedContact& contact, protocol::SealedSessions& sessions,
                       const protocol::SourceAddress& from) {
  const auto opened = sessions.open(first_contact(contact), from);
  return {opened.challenge.begin(), opened.challenge.end()};
}

// First contact, challenge, and the first data.
inline protocol::SealedSessions::Contact establish(protocol::SealedContact& contact, protocol::SealedSessions& sessions,
                                                   const protocol::SourceAddress& from) {
  contact.open(challenge(contact, sessions, from));
  return sessions.open(sealed(contact, Bytes{1}), from).contact;
}

}  // namespace tissued::tests
