#include "protocol/sealed_datagram.hpp"

#include <sodium.h>

#include <algorithm>
#include <string_view>

#include "protocol/bytes.hpp"

namespace tissued::protocol {

static_assert(kSecretKeySize == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);
static_assert(kSealTagSize == crypto_aead_xchacha20poly1305_ietf_ABYTES);

namespace {

constexpr std::array<std::uint8_t, 4> kMagic{'T', 'S', 'E', 'A'};

using Nonce = std::array<std::uint8_t, crypto_aead_xchacha20poly1305_ietf_NPUBBYTES>;

Nonce nonce_of(const SealHeader& header) {
  Nonce nonce{};
  ByteWriter writer(nonce);
  writer.bytes(header.session);
  writer.u64(header.counter);
  return nonce;
}

std::string_view label_of(SealChannel channel, SealDirection direction) {
  const bool to_daemon = direction == SealDirection::to_daemon;
  if (channel == SealChannel::tracker) return to_daemon ? "TSEA1 tracker to daemon" : "TSEA1 daemon to tracker";
  return to_daemon ? "TSEA1 client to daemon" : "TSEA1 daemon to client";
}

template <std::size_t Size>
void read_array(ByteReader& reader, std::array<std::uint8_t, Size>& field) {
  const auto bytes = reader.bytes(Size);
  std::copy(bytes.begin(), bytes.end(), field.begin());
}

bool is_zero(const SealSession& session) { return session == SealSession{}; }

}  // namespace

const char* to_string(SealRefusal refusal) {
  switch (refusal) {
    case SealRefusal::none:
      return "none";
    case SealRefusal::too_short:
      return "too_short";
    case SealRefusal::too_long:
      return "too_long";
    case SealRefusal::bad_magic:
      return "bad_magic";
    case SealRefusal::bad_version:
      return "bad_version";
    case SealRefusal::bad_kind:
      return "bad_kind";
    case SealRefusal::bad_reserved:
      return "bad_reserved";
    case SealRefusal::wrong_size:
      return "wrong_size";
    case SealRefusal::bad_session:
      return "bad_session";
    case SealRefusal::unknown_key:
      return "unknown_key";
    case SealRefusal::wrong_role:
      return "wrong_role";
    case SealRefusal::bad_tag:
      return "bad_tag";
    case SealRefusal::wrong_session:
      return "wrong_session";
    case SealRefusal::table_full:
      return "table_full";
    case SealRefusal::replayed:
      return "replayed";
    case SealRefusal::too_old:
      return "too_old";
  }
  return "unknown";
}

SealRefusal refusal_of(ReplayVerdict verdict) {
  switch (verdict) {
    case ReplayVerdict::fresh:
      return SealRefusal::none;
    case ReplayVerdict::replayed:
      return SealRefusal::replayed;
    case ReplayVerdict::too_old:
      break;
  }
  return SealRefusal::too_old;
}

SealKeyId seal_key_id(const SecretKey& pre_shared) {
  std::array<std::uint8_t, 32> hash{};
  crypto_generichash(hash.data(), hash.size(), pre_shared.bytes().data(), pre_shared.bytes().size(), nullptr, 0);
  SealKeyId id{};
  std::copy_n(hash.begin(), id.size(), id.begin());
  return id;
}

SecretKey seal_key(const SecretKey& pre_shared, SealChannel channel, SealDirection direction) {
  const std::string_view label = label_of(channel, direction);
  std::array<std::uint8_t, kSecretKeySize> derived{};
  crypto_generichash(derived.data(), derived.size(), reinterpret_cast<const unsigned char*>(label.data()), label.size(),
                     pre_shared.bytes().data(), pre_shared.bytes().size());
  SecretKey key(derived);
  sodium_memzero(derived.data(), derived.size());
  return key;
}

SealRefusal read_seal_header(std::span<const std::uint8_t> datagram, SealHeader& header) {
  if (datagram.size() < kMinSealed) return SealRefusal::too_short;
  if (datagram.size() > kMaxSealed) return SealRefusal::too_long;
  ByteReader reader(datagram);
  const auto magic = reader.bytes(kMagic.size());
  if (!std::equal(kMagic.begin(), kMagic.end(), magic.begin(), magic.end())) return SealRefusal::bad_magic;
  if (reader.u8() != kSealVersion) return SealRefusal::bad_version;
  const std::uint8_t kind = reader.u8();
  if (kind > static_cast<std::uint8_t>(SealKind::challenge)) return SealRefusal::bad_kind;
  if (reader.u16() != 0) return SealRefusal::bad_reserved;
  SealHeader read;
  read.kind = static_cast<SealKind>(kind);
  read_array(reader, read.key_id);
  read_array(reader, read.session);
  read_array(reader, read.peer_session);
  read.counter = reader.u64();
  if (read.kind != SealKind::data && datagram.size() != kMinSealed) return SealRefusal::wrong_size;
  const bool knows_peer = read.kind != SealKind::first_contact;
  if (is_zero(read.session) || is_zero(read.peer_session) == knows_peer) return SealRefusal::bad_session;
  header = read;
  return SealRefusal::none;
}

std::size_t seal(const SecretKey& key, const SealHeader& header, std::span<const std::uint8_t> payload,
                 std::span<std::uint8_t> out) {
  if (payload.size() > kMaxDatagram || out.size() < kMinSealed + payload.size()) return 0;
  ByteWriter writer(out);
  writer.bytes(kMagic);
  writer.u8(kSealVersion);
  writer.u8(static_cast<std::uint8_t>(header.kind));
  writer.u16(0);  // reserved
  writer.bytes(header.key_id);
  writer.bytes(header.session);
  writer.bytes(header.peer_session);
  writer.u64(header.counter);
  const Nonce nonce = nonce_of(header);
  crypto_aead_xchacha20poly1305_ietf_encrypt(out.data() + kSealHeaderSize, nullptr, payload.data(), payload.size(),
                                             out.data(), kSealHeaderSize, nullptr, nonce.data(), key.bytes().data());
  return kMinSealed + payload.size();
}

bool unseal(const SecretKey& key, std::span<const std::uint8_t> datagram, const SealHeader& header,
            std::span<std::uint8_t, kMaxDatagram> payload) {
  if (datagram.size() < kMinSealed || datagram.size() > kMaxSealed) return false;
  const auto ciphertext = datagram.subspan(kSealHeaderSize);
  const Nonce nonce = nonce_of(header);
  return crypto_aead_xchacha20poly1305_ietf_decrypt(payload.data(), nullptr, nullptr, ciphertext.data(),
                                                    ciphertext.size(), datagram.data(), kSealHeaderSize, nonce.data(),
                                                    key.bytes().data()) == 0;
}

}  // namespace tissued::protocol
