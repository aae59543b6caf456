#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace tissued::protocol {

// A name as it rides in every datagram: 1 to 24 printable ASCII characters (0x20 to 0x7E), zero-padded to 24 bytes.
// A name of exactly 24 characters has no terminating zero. A default-constructed Name is empty: "no name", never valid
// on the wire.
class Name {
 public:
  static constexpr std::size_t kCapacity = 24;

  Name() = default;

  // nullopt where `text` is empty, longer than 24 characters or holds a byte that is not printable ASCII.
  static std::optional<Name> from(std::string_view text);

  // nullopt for the same reasons, where there are not exactly 24 bytes, and where anything but zeros follows the
  // first zero.
  static std::optional<Name> from_padded(std::span<const std::uint8_t> bytes);

  std::string_view view() const { return {characters_.data(), size_}; }
  bool empty() const { return size_ == 0; }
  // All 24 bytes as they go out, zeros included.
  std::array<std::uint8_t, kCapacity> padded() const;

  friend bool operator==(const Name& a, const Name& b) { return a.view() == b.view(); }

 private:
  std::array<char, kCapacity> characters_{};
  std::uint8_t size_ = 0;
};

}  // namespace tissued::protocol
