#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tissued::protocol {

inline constexpr std::size_t kSecretKeySize = 32;  // bytes

// 256 secret bits. Every copy is wiped from memory when it is dropped.
class SecretKey {
 public:
  explicit SecretKey(std::span<const std::uint8_t, kSecretKeySize> bytes);
  // Drawn by the system. Throws std::runtime_error where the system has no randomness.
  static SecretKey random();

  ~SecretKey();
  SecretKey(const SecretKey&) = default;
  SecretKey& operator=(const SecretKey&) = default;

  std::span<const std::uint8_t, kSecretKeySize> bytes() const { return bytes_; }

 private:
  SecretKey() = default;

  std::array<std::uint8_t, kSecretKeySize> bytes_{};
};

// Fills `out` with bytes that nobody can guess. Throws std::runtime_error where the system has no randomness.
void draw_random(std::span<std::uint8_t> out);

}  // namespace tissued::protocol
