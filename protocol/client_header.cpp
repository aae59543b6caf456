#include "protocol/client_header.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace tissued::protocol {

namespace {

constexpr std::array<std::uint8_t, 4> kMagic{'T', 'S', 'U', 'D'};
constexpr std::size_t kLengthOffset = 20;

std::optional<MessageType> type_of(std::uint8_t code) {
  switch (const auto type = static_cast<MessageType>(code)) {
    case MessageType::hello:
    case MessageType::query_names:
    case MessageType::query_targets:
    case MessageType::query_mesh:
    case MessageType::query_topology:
    case MessageType::query_status:
    case MessageType::subscribe:
    case MessageType::unsubscribe:
    case MessageType::query_probes:
    case MessageType::prove_address:
    case MessageType::hello_reply:
    case MessageType::names:
    case MessageType::predictions:
    case MessageType::mesh_positions:
    case MessageType::mesh_cells:
    case MessageType::status:
    case MessageType::subscribe_reply:
    case MessageType::probe_view:
    case MessageType::address_proof:
    case MessageType::error:
      return type;
  }
  return std::nullopt;
}

}  // namespace

const char* to_string(ClientRefusal refusal) {
  switch (refusal) {
    case ClientRefusal::none:
      return "none";
    case ClientRefusal::too_short:
      return "too_short";
    case ClientRefusal::too_long:
      return "too_long";
    case ClientRefusal::bad_magic:
      return "bad_magic";
    case ClientRefusal::bad_version:
      return "bad_version";
    case ClientRefusal::unknown_flags:
      return "unknown_flags";
    case ClientRefusal::unknown_type:
      return "unknown_type";
    case ClientRefusal::wrong_size:
      return "wrong_size";
    case ClientRefusal::not_finite:
      return "not_finite";
    case ClientRefusal::bad_name:
      return "bad_name";
    case ClientRefusal::bad_value:
      return "bad_value";
  }
  return "unknown";
}

ClientRefusal read_header(ByteReader& reader, std::size_t datagram_size, Header& header) {
  if (datagram_size < kHeaderSize) return ClientRefusal::too_short;
  if (datagram_size > kMaxDatagram) return ClientRefusal::too_long;
  const auto magic = reader.bytes(kMagic.size());
  if (!std::equal(kMagic.begin(), kMagic.end(), magic.begin(), magic.end())) return ClientRefusal::bad_magic;
  if (reader.u8() != kClientVersion) return ClientRefusal::bad_version;
  header.type_code = reader.u8();
  const std::uint16_t flags = reader.u16();
  header.envelope.session = reader.u32();
  header.envelope.sequence = reader.u32();
  header.envelope.in_reply_to = reader.u32();
  const std::uint32_t length = reader.u32();
  if (flags != 0) return ClientRefusal::unknown_flags;
  const auto type = type_of(header.type_code);
  if (!type) return ClientRefusal::unknown_type;
  header.type = *type;
  return length == datagram_size ? ClientRefusal::none : ClientRefusal::wrong_size;
}

void write_header(ByteWriter& writer, MessageType type, const Envelope& envelope) {
  writer.bytes(kMagic);
  writer.u8(kClientVersion);
  writer.u8(static_cast<std::uint8_t>(type));
  writer.u16(0);  // flags: none defined
  writer.u32(envelope.session);
  writer.u32(envelope.sequence);
  writer.u32(envelope.in_reply_to);
  writer.u32(0);  // length: finish_message knows
}

std::size_t finish_message(ByteWriter& writer) {
  writer.patch_u32(kLengthOffset, static_cast<std::uint32_t>(writer.size()));
  return writer.ok() && writer.finite() ? writer.size() : 0;
}

}  // namespace tissued::protocol
