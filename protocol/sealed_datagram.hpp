#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/client_header.hpp"
#include "protocol/replay_window.hpp"
#include "protocol/secret_key.hpp"

// The envelope in which a datagram of either protocol is encrypted and authenticated under a key that both ends were
// given beforehand (protocol/README.md has the byte tables). Here are its bytes; who may send what, and when, is
// SealedContact's and SealedSessions'.

namespace tissued::protocol {

inline constexpr std::uint8_t kSealVersion = 1;
inline constexpr std::size_t kSealHeaderSize = 56;  // bytes; all of it is authenticated
inline constexpr std::size_t kSealTagSize = 16;     // bytes
inline constexpr std::size_t kMinSealed = kSealHeaderSize + kSealTagSize;
inline constexpr std::size_t kMaxSealed = kMinSealed + kMaxDatagram;
static_assert(kMaxSealed <= 1472, "goes whole into a UDP datagram on Ethernet");

enum class SealKind : std::uint8_t {
  data = 0,
  first_contact = 1,  // asks for the session of the other end
  challenge = 2,      // tells it
};

// What a key is used for, and which way: each has a key of its own, made of the pre-shared one, so that nothing sealed
// for one place opens at another, least of all at its own sender.
enum class SealChannel : std::uint8_t { tracker, client };
enum class SealDirection : std::uint8_t { to_daemon, from_daemon };

using SealKeyId = std::array<std::uint8_t, 8>;
using SealSession = std::array<std::uint8_t, 16>;

struct SealHeader {
  SealKind kind = SealKind::data;
  SealKeyId key_id{};
  SealSession session{};       // of the sender
  SealSession peer_session{};  // of the receiver, as the sender knows it; zeros in a first contact
  std::uint64_t counter = 0;   // rises with every datagram of the session

  friend bool operator==(const SealHeader&, const SealHeader&) = default;
};

// The gates in the order in which they are asked; the first that fails names the refusal.
enum class SealRefusal : std::uint8_t {
  none,
  too_short,      // no header and tag
  too_long,       // more than kMaxSealed
  bad_magic,      // not 'TSEA'
  bad_version,    // not kSealVersion
  bad_kind,       // no SealKind, or none that goes this way
  bad_reserved,   // a reserved byte that is not 0
  wrong_size,     // a first contact or a challenge that carries something
  bad_session,    // zeros where a session belongs, or a session where zeros do
  unknown_key,    // a key id of no key here
  wrong_role,     // a key that is for other things
  bad_tag,        // not sealed under that key for this channel and direction, or changed since
  wrong_session,  // meant for another receiver, another start, or another contact than this
  table_full,     // a new contact, and every place is taken by one that is kept
  replayed,       // taken before
  too_old,        // too far behind the newest to know whether it was taken
};
inline constexpr std::size_t kSealRefusalCount = 16;

const char* to_string(SealRefusal refusal);
SealRefusal refusal_of(ReplayVerdict verdict);

// Names the key without telling it.
SealKeyId seal_key_id(const SecretKey& pre_shared);
SecretKey seal_key(const SecretKey& pre_shared, SealChannel channel, SealDirection direction);

// Asks the gates from too_short to bad_session; `header` is filled where they all pass. Nothing in it is to be believed
// before unseal.
SealRefusal read_seal_header(std::span<const std::uint8_t> datagram, SealHeader& header);

// Writes the whole datagram and returns its size; 0 where the payload is longer than kMaxDatagram or `out` too small.
// `payload` does not lie in `out`. No two datagrams under one key may have the same session and counter.
std::size_t seal(const SecretKey& key, const SealHeader& header, std::span<const std::uint8_t> payload,
                 std::span<std::uint8_t> out);

// Decrypts a datagram whose header has been read, which leaves datagram.size() - kMinSealed bytes in `payload`. False,
// and nothing of use there, where the tag is wrong.
bool unseal(const SecretKey& key, std::span<const std::uint8_t> datagram, const SealHeader& header,
            std::span<std::uint8_t, kMaxDatagram> payload);

}  // namespace tissued::protocol
