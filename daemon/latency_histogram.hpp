#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace tissued::daemon {

/// Durations since the start of the process in log-linear buckets, 32 to the octave: a percentile is right to 3 %.
/// One thread adds, any may read; neither waits nor allocates. Durations above 2^40 ns (18 min) count as that.
class LatencyHistogram {
 public:
  void add(std::uint64_t duration_ns) noexcept;

  std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  std::uint64_t max_ns() const noexcept { return max_.load(std::memory_order_relaxed); }

  /// The duration that `share` (0 to 1) of all durations did not exceed: upper edge of its bucket, at most max_ns().
  /// 0 before the first one.
  std::uint64_t percentile_ns(double share) const noexcept;

 private:
  static constexpr unsigned kSubBits = 5;  // 32 buckets to the octave
  static constexpr unsigned kOctaves = 40;
  static constexpr std::size_t kBuckets = (kOctaves - kSubBits + 2) << kSubBits;

  static std::size_t bucket_of(std::uint64_t duration_ns) noexcept;
  static std::uint64_t upper_edge(std::size_t bucket) noexcept;

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::uint64_t> max_{0};
};

}  // namespace tissued::daemon
