#pragma once

#include <cstddef>
#include <cstdint>

#include "protocol/bytes.hpp"

// What every datagram of our client protocol begins with (protocol/README.md has the byte tables).

namespace tissued::protocol {

inline constexpr std::uint16_t kClientPort = 51010;
inline constexpr std::uint8_t kClientVersion = 2;
inline constexpr std::size_t kMaxDatagram = 1400;  // bytes: below the MTU of Ethernet with room for tunnels
inline constexpr std::size_t kHeaderSize = 24;     // bytes

enum class MessageType : std::uint8_t {
  // client to daemon
  hello = 0x01,
  query_names = 0x02,
  query_targets = 0x03,
  query_mesh = 0x04,
  query_topology = 0x05,
  query_status = 0x06,
  subscribe = 0x07,
  unsubscribe = 0x08,
  query_probes = 0x09,
  prove_address = 0x0A,
  // daemon to client
  hello_reply = 0x81,
  names = 0x82,
  predictions = 0x83,
  mesh_positions = 0x84,
  mesh_cells = 0x85,
  status = 0x86,
  subscribe_reply = 0x87,
  probe_view = 0x88,
  address_proof = 0x89,
  error = 0xFF,
};

// Who sends, in which order, and in answer to what.
struct Envelope {
  std::uint32_t session = 0;   // drawn anew whenever the sender starts; sequences of different sessions do not compare
  std::uint32_t sequence = 0;  // one up for every datagram sent to this peer, modulo 2^32
  std::uint32_t in_reply_to = 0;  // sequence of the request; 0 where nobody asked (subscriptions); requests start at 1
};

// The gates in the order in which they are asked; the first that fails names the refusal.
enum class ClientRefusal : std::uint8_t {
  none,
  too_short,      // no full header
  too_long,       // more than kMaxDatagram
  bad_magic,      // not 'TSUD'
  bad_version,    // not kClientVersion
  unknown_flags,  // reserved bits set: something we would have to understand, such as an authentication trailer
  unknown_type,   // no MessageType
  wrong_size,     // the header's length, the datagram's, or the body's own counts disagree
  not_finite,     // NaN or infinity
  bad_name,       // empty, not printable ASCII, or not zero-padded
  bad_value,      // beyond the field's stated limits
};
inline constexpr std::size_t kClientRefusalCount = 11;

const char* to_string(ClientRefusal refusal);

struct Header {
  std::uint8_t type_code = 0;             // as it came, known or not
  MessageType type = MessageType::error;  // where type_code is one
  Envelope envelope;
};

// Reads 24 bytes and asks the gates from too_short to wrong_size (the header's length against `datagram_size`).
// `header` is filled as soon as magic and version are right, so that an error can be answered.
ClientRefusal read_header(ByteReader& reader, std::size_t datagram_size, Header& header);

// Writes the header with a length of 0, for finish_message to fill in.
void write_header(ByteWriter& writer, MessageType type, const Envelope& envelope);

// Fills in the length. Returns the size of the datagram, or 0 where the writer ran out of room or wrote a number that
// is not finite. No message has room for more than kMaxDatagram.
std::size_t finish_message(ByteWriter& writer);

}  // namespace tissued::protocol
