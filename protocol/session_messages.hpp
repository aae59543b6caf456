#pragma once

#include <array>
#include <cstdint>

#include "protocol/client_header.hpp"
#include "protocol/fixed_list.hpp"
#include "protocol/mesh_messages.hpp"
#include "protocol/name.hpp"

// Meeting, names, subscriptions and errors.

namespace tissued::protocol {

// First message of a client; answered by HelloReply. Asking again is harmless.
struct Hello {
  static constexpr MessageType kType = MessageType::hello;
  Name client;
};

struct HelloReply {
  static constexpr MessageType kType = MessageType::hello_reply;
  Name version;    // of the daemon
  Name model;      // the config's or bundle's name
  Name simulator;  // kf-admm, admm, ...
  Name units;      // "mm s N", for a reader's eyes
  double nominal_rate_hz = 0;
  std::uint32_t node_count = 0;
  std::uint32_t tetrahedron_count = 0;
  std::uint32_t triangle_count = 0;  // of the skin
  std::uint16_t target_count = 0;
  std::uint16_t marker_count = 0;
  std::uint16_t pad_count = 0;
};

enum class NameKind : std::uint8_t { target = 0, marker = 1, pad = 2, counter = 3, probe = 4 };

// Asks for a table of names; answered by as many Names as the table needs (one where it is empty). Every other message
// speaks of a target, marker, pad, counter or probe by its index in its table; tables do not change within a session.
struct QueryNames {
  static constexpr MessageType kType = MessageType::query_names;
  NameKind kind = NameKind::target;
};

struct Names {
  static constexpr MessageType kType = MessageType::names;
  NameKind kind = NameKind::target;
  std::uint16_t total = 0;  // names in the table
  std::uint16_t first = 0;  // index of names[0]
  FixedList<Name, 57> names;
};

// What a subscription streams; a set of bits.
enum What : std::uint8_t { kTargets = 1, kMesh = 2, kStatus = 4, kProbes = 8 };

inline constexpr double kMaxRate_hz = 10000;
inline constexpr std::uint16_t kMaxLease_s = 3600;

// One subscription per client address; a new one replaces it, and renews its lease.
struct Subscribe {
  static constexpr MessageType kType = MessageType::subscribe;
  std::uint8_t what = kTargets;              // at least one What
  Precision precision = Precision::float32;  // of mesh positions
  std::uint16_t lease_s = 10;                // 1 .. kMaxLease_s; the stream ends then unless renewed
  double rate_hz = 0;                        // 0: after every tracker frame; at most kMaxRate_hz
};

// What was granted, which may be less than was asked.
struct SubscribeReply {
  static constexpr MessageType kType = MessageType::subscribe_reply;
  std::uint8_t what = 0;
  Precision precision = Precision::float32;
  std::uint16_t lease_s = 0;  // 0: no subscription (any more)
  double rate_hz = 0;
};

// Answered by SubscribeReply with a lease of 0.
struct Unsubscribe {
  static constexpr MessageType kType = MessageType::unsubscribe;
};

// What AddressCookie makes; zeros: none.
using CookieBytes = std::array<std::uint8_t, 16>;

// That whoever sends from this address receives there, too: a daemon that others than this machine reach without keys
// answers nothing else before. First without a cookie, then with the one of the reply.
struct ProveAddress {
  static constexpr MessageType kType = MessageType::prove_address;
  CookieBytes cookie{};
};

// As long as its question: zeros where the address is proven, else the cookie to show.
struct AddressProof {
  static constexpr MessageType kType = MessageType::address_proof;
  CookieBytes cookie{};
};

enum class ErrorReason : std::uint8_t {
  refused = 0,           // the request did not pass a gate: see `refusal`
  not_a_request = 1,     // a message that only the daemon sends
  too_many_clients = 2,  // no room for another subscription
  not_available = 3,     // this daemon has no such thing, such as a mesh behind the simulator `rigid`
  address_unproven = 4,  // see ProveAddress; sent only where the request was at least as long
};

const char* to_string(ErrorReason reason);

// Answer to a request that cannot be served. Never sent in answer to an Error, nor to a bad magic or a short datagram.
struct Error {
  static constexpr MessageType kType = MessageType::error;
  ErrorReason reason = ErrorReason::refused;
  ClientRefusal refusal = ClientRefusal::none;
  std::uint8_t request_type = 0;  // as it came, known or not
};

// Bodies, after the header. A read stops at nothing but a count that no datagram can hold (wrong_size), and otherwise
// returns bad_name, bad_value or none; whether the reader came out even and finite is asked first, by
// decode_client_message.
ClientRefusal read_body(ByteReader& reader, Hello& message);
ClientRefusal read_body(ByteReader& reader, HelloReply& message);
ClientRefusal read_body(ByteReader& reader, QueryNames& message);
ClientRefusal read_body(ByteReader& reader, Names& message);
ClientRefusal read_body(ByteReader& reader, Subscribe& message);
ClientRefusal read_body(ByteReader& reader, SubscribeReply& message);
ClientRefusal read_body(ByteReader& reader, Unsubscribe& message);
ClientRefusal read_body(ByteReader& reader, ProveAddress& message);
ClientRefusal read_body(ByteReader& reader, AddressProof& message);
ClientRefusal read_body(ByteReader& reader, Error& message);
void write_body(ByteWriter& writer, const Hello& message);
void write_body(ByteWriter& writer, const HelloReply& message);
void write_body(ByteWriter& writer, const QueryNames& message);
void write_body(ByteWriter& writer, const Names& message);
void write_body(ByteWriter& writer, const Subscribe& message);
void write_body(ByteWriter& writer, const SubscribeReply& message);
void write_body(ByteWriter& writer, const Unsubscribe& message);
void write_body(ByteWriter& writer, const ProveAddress& message);
void write_body(ByteWriter& writer, const AddressProof& message);
void write_body(ByteWriter& writer, const Error& message);

}  // namespace tissued::protocol
