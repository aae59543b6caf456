#pragma once

#include <cstdint>
#include <vector>

#include "protocol/client_messages.hpp"

// One message of every type, each field with a value of its own. tests/protocol/wire_peer.py packs the same ones, in
// the same order, from the byte tables of protocol/README.md.

namespace tissued::protocol {

struct Sample {
  Envelope envelope;
  ClientMessage message;
};

std::vector<Sample> client_samples();

// The datagram of a message, at most kMaxDatagram; empty where it cannot be encoded.
std::vector<std::uint8_t> encoded(const Envelope& envelope, const ClientMessage& message);

}  // namespace tissued::protocol
