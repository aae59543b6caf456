#include "protocol/client_messages.hpp"

namespace tissued::protocol {

namespace {

// The gates after the header: exact size, finite values, then what the body says of its own fields.
template <typename Message>
ClientRefusal read_as(ByteReader& reader, ClientMessage& message) {
  const ClientRefusal body = read_body(reader, message.emplace<Message>());
  if (!reader.ok() || reader.remaining() != 0) return ClientRefusal::wrong_size;
  if (body == ClientRefusal::wrong_size) return body;
  return reader.finite() ? body : ClientRefusal::not_finite;
}

ClientRefusal read_message(ByteReader& reader, MessageType type, ClientMessage& message) {
  switch (type) {
    case MessageType::hello:
      return read_as<Hello>(reader, message);
    case MessageType::query_names:
      return read_as<QueryNames>(reader, message);
    case MessageType::query_targets:
      return read_as<QueryTargets>(reader, message);
    case MessageType::query_mesh:
      return read_as<QueryMesh>(reader, message);
    case MessageType::query_topology:
      return read_as<QueryTopology>(reader, message);
    case MessageType::query_status:
      return read_as<QueryStatus>(reader, message);
    case MessageType::subscribe:
      return read_as<Subscribe>(reader, message);
    case MessageType::unsubscribe:
      return read_as<Unsubscribe>(reader, message);
    case MessageType::query_probes:
      return read_as<QueryProbes>(reader, message);
    case MessageType::prove_address:
      return read_as<ProveAddress>(reader, message);
    case MessageType::hello_reply:
      return read_as<HelloReply>(reader, message);
    case MessageType::names:
      return read_as<Names>(reader, message);
    case MessageType::predictions:
      return read_as<Predictions>(reader, message);
    case MessageType::mesh_positions:
      return read_as<MeshPositions>(reader, message);
    case MessageType::mesh_cells:
      return read_as<MeshCells>(reader, message);
    case MessageType::status:
      return read_as<Status>(reader, message);
    case MessageType::subscribe_reply:
      return read_as<SubscribeReply>(reader, message);
    case MessageType::probe_view:
      return read_as<ProbeView>(reader, message);
    case MessageType::address_proof:
      return read_as<AddressProof>(reader, message);
    case MessageType::error:
      return read_as<Error>(reader, message);
  }
  return ClientRefusal::unknown_type;
}

}  // namespace

DecodedMessage decode_client_message(std::span<const std::uint8_t> bytes) {
  DecodedMessage decoded;
  ByteReader reader(bytes);
  decoded.refusal = read_header(reader, bytes.size(), decoded.header);
  if (decoded.refusal != ClientRefusal::none) return decoded;
  decoded.refusal = read_message(reader, decoded.header.type, decoded.message);
  return decoded;
}

}  // namespace tissued::protocol
