// FNV-1a over the bits of doubles: equal hashes prove an equal run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tissued::core {

class StateHash {
 public:
  void mix(const double* values, std::ptrdiff_t count) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      std::uint64_t bits;
      std::memcpy(&bits, values + i, sizeof bits);
      value_ = (value_ ^ bits) * 1099511628211ull;
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

}  // namespace tissued::core
