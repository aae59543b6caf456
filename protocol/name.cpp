#include "protocol/name.hpp"

#include <algorithm>

namespace tissued::protocol {

std::optional<Name> Name::from(std::string_view text) {
  if (text.empty() || text.size() > kCapacity) return std::nullopt;
  const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c <= 0x7E; });
  if (!printable) return std::nullopt;
  Name name;
  std::copy(text.begin(), text.end(), name.characters_.begin());
  name.size_ = static_cast<std::uint8_t>(text.size());
  return name;
}

std::optional<Name> Name::from_padded(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kCapacity) return std::nullopt;
  const auto end = std::find(bytes.begin(), bytes.end(), std::uint8_t{0});
  if (!std::all_of(end, bytes.end(), [](std::uint8_t byte) { return byte == 0; })) return std::nullopt;
  std::array<char, kCapacity> text{};
  std::transform(bytes.begin(), end, text.begin(), [](std::uint8_t byte) { return static_cast<char>(byte); });
  return from({text.data(), static_cast<std::size_t>(end - bytes.begin())});
}

std::array<std::uint8_t, Name::kCapacity> Name::padded() const {
  std::array<std::uint8_t, kCapacity> bytes{};
  std::transform(characters_.begin(), characters_.end(), bytes.begin(),
                 [](char c) { return static_cast<std::uint8_t>(c); });
  return bytes;
}

}  // namespace tissued::protocol
