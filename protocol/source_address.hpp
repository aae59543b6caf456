#pragma once

#include <array>
#include <cstdint>

namespace tissued::protocol {

// Where a datagram says it comes from. Anybody can write another's address there.
struct SourceAddress {
  std::array<std::uint8_t, 16> ip{};  // IPv6 as it stands in packets; IPv4 a.b.c.d as ::ffff:a.b.c.d
  std::uint16_t port = 0;

  friend bool operator==(const SourceAddress&, const SourceAddress&) = default;
};

}  // namespace tissued::protocol
