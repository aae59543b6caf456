#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "protocol/client_header.hpp"
#include "protocol/mesh_messages.hpp"
#include "protocol/prediction_messages.hpp"
#include "protocol/probe_messages.hpp"
#include "protocol/session_messages.hpp"
#include "protocol/status_messages.hpp"

// Our client protocol: any message <-> one datagram.

namespace tissued::protocol {

using ClientMessage = std::variant<Hello, QueryNames, QueryTargets, QueryMesh, QueryTopology, QueryStatus, Subscribe,
                                   Unsubscribe, HelloReply, Names, Predictions, MeshPositions, MeshCells, Status,
                                   SubscribeReply, Error, QueryProbes, ProbeView, ProveAddress, AddressProof>;

struct DecodedMessage {
  ClientRefusal refusal = ClientRefusal::none;
  Header header;          // valid as far as the gates were passed; see read_header
  ClientMessage message;  // meaningful only where nothing was refused
};

// Decodes one datagram through the gates of ClientRefusal, in their order. No allocation, no exception.
// Sequence and age are the receiver's to judge: see SequenceGate, and the `_ns` fields.
DecodedMessage decode_client_message(std::span<const std::uint8_t> bytes);

// Writes one datagram and returns its size; 0 where `buffer` is too small (kMaxDatagram always suffices) or a number is
// not finite. Counts are taken from the lists.
template <typename Message>
std::size_t encode_client_message(const Envelope& envelope, const Message& message, std::span<std::uint8_t> buffer) {
  ByteWriter writer(buffer);
  write_header(writer, Message::kType, envelope);
  write_body(writer, message);
  return finish_message(writer);
}

}  // namespace tissued::protocol
