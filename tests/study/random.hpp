// Draws that are the same on every platform (the standard's distributions are not).
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "core/types.hpp"

namespace tissued::study {

class Random {
 public:
  // Streams of neighbouring seeds have nothing in common.
  explicit Random(std::uint64_t seed) {
    std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), 0x6e756c6cu};
    generator_.seed(sequence);
  }

  double uniform(double low, double high) { return low + (high - low) * (static_cast<double>(generator_()) + 0.5) / k; }
  int integer(int low, int high) {
    return low + static_cast<int>(generator_() % static_cast<unsigned>(high - low + 1));
  }
  bool chance(double share) { return uniform(0.0, 1.0) < share; }
  // Evenly in the logarithm.
  double logarithmic(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  double normal() { return std::sqrt(-2.0 * std::log(uniform(0.0, 1.0))) * std::cos(uniform(0.0, 6.283185307179586)); }
  core::Vec3 normal_vector() {
    core::Vec3 v;
    for (double& entry : v) entry = normal();
    return v;
  }

 private:
  static constexpr double k = 4294967296.0;
  std::mt19937 generator_;
};

}  // namespace tissued::study
