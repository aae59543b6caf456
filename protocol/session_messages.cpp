#include "protocol/session_messages.hpp"

#include <algorithm>

namespace tissued::protocol {

namespace {

constexpr std::uint8_t kAllWhat = kTargets | kMesh | kStatus | kProbes;

bool read_name(ByteReader& reader, Name& name) {
  const auto read = Name::from_padded(reader.bytes(Name::kCapacity));
  if (read) name = *read;
  return read.has_value();
}

bool read_kind(ByteReader& reader, NameKind& kind) {
  kind = static_cast<NameKind>(reader.u8());
  return kind <= NameKind::probe;
}

ClientRefusal read_cookie(ByteReader& reader, CookieBytes& cookie) {
  const auto bytes = reader.bytes(cookie.size());
  std::copy(bytes.begin(), bytes.end(), cookie.begin());
  return ClientRefusal::none;
}

ClientRefusal value_gate(bool good) { return good ? ClientRefusal::none : ClientRefusal::bad_value; }

// Subscribe and its reply share their layout; the reply may also say "nothing".
template <typename Message>
void read_terms(ByteReader& reader, Message& message) {
  message.what = reader.u8();
  message.precision = static_cast<Precision>(reader.u8());
  message.lease_s = reader.u16();
  message.rate_hz = reader.f64();
}

template <typename Message>
void write_terms(ByteWriter& writer, const Message& message) {
  writer.u8(message.what);
  writer.u8(static_cast<std::uint8_t>(message.precision));
  writer.u16(message.lease_s);
  writer.f64(message.rate_hz);
}

template <typename Message>
bool terms_in_limits(const Message& message) {
  return message.what <= kAllWhat && is_precision(message.precision) && message.lease_s <= kMaxLease_s &&
         message.rate_hz >= 0 && message.rate_hz <= kMaxRate_hz;
}

}  // namespace

const char* to_string(ErrorReason reason) {
  switch (reason) {
    case ErrorReason::refused:
      return "refused";
    case ErrorReason::not_a_request:
      return "not_a_request";
    case ErrorReason::too_many_clients:
      return "too_many_clients";
    case ErrorReason::not_available:
      return "not_available";
    case ErrorReason::address_unproven:
      return "address_unproven";
  }
  return "unknown";
}

ClientRefusal read_body(ByteReader& reader, Hello& message) {
  return read_name(reader, message.client) ? ClientRefusal::none : ClientRefusal::bad_name;
}

void write_body(ByteWriter& writer, const Hello& message) { writer.bytes(message.client.padded()); }

ClientRefusal read_body(ByteReader& reader, HelloReply& message) {
  bool names_good = read_name(reader, message.version);
  names_good = read_name(reader, message.model) && names_good;
  names_good = read_name(reader, message.simulator) && names_good;
  names_good = read_name(reader, message.units) && names_good;
  message.nominal_rate_hz = reader.f64();
  message.node_count = reader.u32();
  message.tetrahedron_count = reader.u32();
  message.triangle_count = reader.u32();
  message.target_count = reader.u16();
  message.marker_count = reader.u16();
  message.pad_count = reader.u16();
  if (!names_good) return ClientRefusal::bad_name;
  return value_gate(message.nominal_rate_hz >= 0 && message.nominal_rate_hz <= kMaxRate_hz);
}

void write_body(ByteWriter& writer, const HelloReply& message) {
  writer.bytes(message.version.padded());
  writer.bytes(message.model.padded());
  writer.bytes(message.simulator.padded());
  writer.bytes(message.units.padded());
  writer.f64(message.nominal_rate_hz);
  writer.u32(message.node_count);
  writer.u32(message.tetrahedron_count);
  writer.u32(message.triangle_count);
  writer.u16(message.target_count);
  writer.u16(message.marker_count);
  writer.u16(message.pad_count);
}

ClientRefusal read_body(ByteReader& reader, QueryNames& message) { return value_gate(read_kind(reader, message.kind)); }

void write_body(ByteWriter& writer, const QueryNames& message) { writer.u8(static_cast<std::uint8_t>(message.kind)); }

ClientRefusal read_body(ByteReader& reader, Names& message) {
  const bool kind_good = read_kind(reader, message.kind);
  const std::uint8_t count = reader.u8();
  message.total = reader.u16();
  message.first = reader.u16();
  if (!message.names.resize(count)) return ClientRefusal::wrong_size;
  bool names_good = true;
  for (Name& name : message.names) names_good = read_name(reader, name) && names_good;
  if (!names_good) return ClientRefusal::bad_name;
  return value_gate(kind_good && message.first + count <= message.total);
}

void write_body(ByteWriter& writer, const Names& message) {
  writer.u8(static_cast<std::uint8_t>(message.kind));
  writer.u8(static_cast<std::uint8_t>(message.names.size()));
  writer.u16(message.total);
  writer.u16(message.first);
  for (const Name& name : message.names) writer.bytes(name.padded());
}

ClientRefusal read_body(ByteReader& reader, Subscribe& message) {
  read_terms(reader, message);
  return value_gate(terms_in_limits(message) && message.what != 0 && message.lease_s != 0);
}

void write_body(ByteWriter& writer, const Subscribe& message) { write_terms(writer, message); }

ClientRefusal read_body(ByteReader& reader, SubscribeReply& message) {
  read_terms(reader, message);
  return value_gate(terms_in_limits(message));
}

void write_body(ByteWriter& writer, const SubscribeReply& message) { write_terms(writer, message); }

ClientRefusal read_body(ByteReader&, Unsubscribe&) { return ClientRefusal::none; }

void write_body(ByteWriter&, const Unsubscribe&) {}

ClientRefusal read_body(ByteReader& reader, ProveAddress& message) { return read_cookie(reader, message.cookie); }

void write_body(ByteWriter& writer, const ProveAddress& message) { writer.bytes(message.cookie); }

ClientRefusal read_body(ByteReader& reader, AddressProof& message) { return read_cookie(reader, message.cookie); }

void write_body(ByteWriter& writer, const AddressProof& message) { writer.bytes(message.cookie); }

ClientRefusal read_body(ByteReader& reader, Error& message) {
  message.reason = static_cast<ErrorReason>(reader.u8());
  message.refusal = static_cast<ClientRefusal>(reader.u8());
  message.request_type = reader.u8();
  const bool reserved_zero = reader.u8() == 0;
  return value_gate(message.reason <= ErrorReason::address_unproven && message.refusal <= ClientRefusal::bad_value &&
                    reserved_zero);
}

void write_body(ByteWriter& writer, const Error& message) {
  writer.u8(static_cast<std::uint8_t>(message.reason));
  writer.u8(static_cast<std::uint8_t>(message.refusal));
  writer.u8(message.request_type);
  writer.u8(0);
}

}  // namespace tissued::protocol
