#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/secret_key.hpp"
#include "protocol/source_address.hpp"

namespace tissued::protocol {

// Whoever shows the cookie of an address has received at that address within the last 30 to 60 s, so that what is sent
// there floods nobody else. Nothing is remembered of those who were given one. It proves no identity: whoever reads the
// traffic of an address can show its cookie.
class AddressCookie {
 public:
  static constexpr std::size_t kSize = 16;                       // bytes
  static constexpr std::uint64_t kEpoch_ns = 30'000'000'000ULL;  // a cookie is good in its epoch and in the next
  using Bytes = std::array<std::uint8_t, kSize>;

  // Under a secret of its own: cookies of an earlier start are void. Throws as SecretKey::random does.
  AddressCookie() : AddressCookie(SecretKey::random()) {}
  explicit AddressCookie(const SecretKey& secret) : secret_(secret) {}

  // now_ns: any clock that does not go back.
  Bytes make(const SourceAddress& address, std::uint64_t now_ns) const;
  // False where there are not exactly 16 bytes.
  bool is_good(std::span<const std::uint8_t> cookie, const SourceAddress& address, std::uint64_t now_ns) const;

 private:
  Bytes of_epoch(const SourceAddress& address, std::uint64_t epoch) const;

  SecretKey secret_;
};

}  // namespace tissued::protocol
