#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tissued::daemon {

/// How many durations there were up to each of some limits, since the start: what Prometheus takes for a histogram. For
/// one thread; nothing allocates.
class DurationHistogram {
 public:
  /// s, rising; what is longer than the last is counted without a limit.
  static constexpr std::array<double, 14> kLimits{0.0005, 0.001, 0.002, 0.003, 0.004, 0.005, 0.0075,
                                                  0.01,   0.015, 0.02,  0.05,  0.1,   0.5,   1.0};

  void add(std::uint64_t duration_ns) noexcept {
    const double seconds = 1e-9 * static_cast<double>(duration_ns);
    std::size_t limit = 0;
    while (limit < kLimits.size() && seconds > kLimits[limit]) ++limit;
    ++counts_[limit];
    sum_ += seconds;
  }

  /// Of durations above kLimits[limit - 1] and not above kLimits[limit]; at kLimits.size(): above all.
  std::uint64_t count(std::size_t limit) const noexcept { return counts_[limit]; }
  double sum() const noexcept { return sum_; }  ///< s

 private:
  std::array<std::uint64_t, kLimits.size() + 1> counts_{};
  double sum_ = 0.0;
};

}  // namespace tissued::daemon
