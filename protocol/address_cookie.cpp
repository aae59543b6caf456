#include "protocol/address_cookie.hpp"

#include <sodium.h>

#include "protocol/bytes.hpp"

namespace tissued::protocol {

AddressCookie::Bytes AddressCookie::make(const SourceAddress& address, std::uint64_t now_ns) const {
  return of_epoch(address, now_ns / kEpoch_ns);
}

bool AddressCookie::is_good(std::span<const std::uint8_t> cookie, const SourceAddress& address,
                            std::uint64_t now_ns) const {
  if (cookie.size() != kSize) return false;
  // In constant time: how long a comparison takes would tell a guesser how far he got.
  const auto is_of = [&](std::uint64_t epoch) {
    return sodium_memcmp(cookie.data(), of_epoch(address, epoch).data(), kSize) == 0;
  };
  const std::uint64_t epoch = now_ns / kEpoch_ns;
  return is_of(epoch) || is_of(epoch - 1);  // the one before the first is one that never comes
}

AddressCookie::Bytes AddressCookie::of_epoch(const SourceAddress& address, std::uint64_t epoch) const {
  std::array<std::uint8_t, 26> message{};
  ByteWriter writer(message);
  writer.bytes(address.ip);
  writer.u16(address.port);
  writer.u64(epoch);
  Bytes cookie{};
  crypto_generichash(cookie.data(), cookie.size(), message.data(), message.size(), secret_.bytes().data(),
                     secret_.bytes().size());
  return cookie;
}

}  // namespace tissued::protocol
