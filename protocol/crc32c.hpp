#pragma once

#include <cstdint>
#include <span>

namespace tissued::protocol {

// CRC-32C (Castagnoli; RFC 3720, appendix B.4) of the bytes, going on from `before`, the checksum of those before them.
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

}  // namespace tissued::protocol
