// Both ends of sealed traffic, and what somebody in between could send.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/protocol/seal_samples.hpp"

namespace tissued::tests {

using protocol::SealChannel;
using protocol::SealDirection;
using protocol::SealedContact;
using protocol::SealedSessions;
using protocol::SealHeader;
using protocol::SealKind;
using protocol::SealRefusal;
using protocol::SealSession;
using protocol::SecretKey;
using protocol::SourceAddress;

inline const SourceAddress kHome = sample_address(1);

inline std::vector<SealedSessions::Key> sample_keys() {
  return {{sample_key(0)}, {sample_key(1)}, {sample_key(2), false}};
}

struct Ends {
  SealedSessions daemon{SealChannel::client, sample_keys()};
  SealedContact client{SealChannel::client, sample_key(0)};
};

inline std::string refusal_at(SealedSessions& daemon, const Bytes& datagram, const SourceAddress& from = kHome) {
  const auto opened = daemon.open(datagram, from);
  const bool taken = opened.refusal == SealRefusal::none && opened.kind == SealKind::data;
  CHECK(daemon.has_place(opened.contact) == taken);
  if (!taken) CHECK(opened.payload.empty());
  CHECK(opened.challenge.size() <= datagram.size());
  return to_string(opened.refusal);
}

inline std::string refusal_at(SealedContact& client, const Bytes& datagram) {
  const auto opened = client.open(datagram);
  if (opened.refusal != SealRefusal::none) CHECK(opened.payload.empty());
  return to_string(opened.refusal);
}

// A datagram such as the owner of the key could make.
inline Bytes forged(const SecretKey& pre_shared, SealDirection direction, SealHeader header, const Bytes& payload,
                    SealChannel channel = SealChannel::client) {
  header.key_id = protocol::seal_key_id(pre_shared);
  Bytes datagram(protocol::kMaxSealed);
  datagram.resize(protocol::seal(protocol::seal_key(pre_shared, channel, direction), header, payload, datagram));
  return datagram;
}

inline SealHeader header_of(const Bytes& datagram) {
  SealHeader header;
  REQUIRE(read_seal_header(datagram, header) == SealRefusal::none);
  return header;
}

// As many established contacts as asked for, each at a port of its own.
struct Crowd {
  explicit Crowd(SealedSessions& daemon, std::size_t count, std::uint16_t first_port = 1000) {
    for (std::size_t i = 0; i < count; ++i) {
      addresses.push_back(sample_address(7, static_cast<std::uint16_t>(first_port + i)));
      clients.push_back(std::make_unique<SealedContact>(SealChannel::client, sample_key(0)));
      contacts.push_back(establish(*clients.back(), daemon, addresses.back()));
    }
  }
  std::vector<SourceAddress> addresses;
  std::vector<std::unique_ptr<SealedContact>> clients;
  std::vector<SealedSessions::Contact> contacts;
};

}  // namespace tissued::tests
