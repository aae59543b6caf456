#include "protocol/secret_key.hpp"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>

namespace tissued::protocol {

SecretKey::SecretKey(std::span<const std::uint8_t, kSecretKeySize> bytes) {
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
}

SecretKey SecretKey::random() {
  SecretKey key;
  draw_random(key.bytes_);
  return key;
}

SecretKey::~SecretKey() { sodium_memzero(bytes_.data(), bytes_.size()); }

void draw_random(std::span<std::uint8_t> out) {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot start: no source of randomness");
  randombytes_buf(out.data(), out.size());
}

}  // namespace tissued::protocol
