#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tissued::daemon {

/// The most recent kCapacity durations and their percentiles. Adding one and asking for a percentile cost the same
/// however many there are; nothing allocates. For one thread.
///
/// Beside the list of durations their counts are kept in log-linear buckets, 32 to the octave: a percentile is right to
/// 3 %. Durations above 2^40 ns (18 min) count as that.
class LatencyWindow {
 public:
  static constexpr std::size_t kCapacity = 8192;  // 80 s at 100 Hz

  void add(std::uint64_t duration_ns) noexcept;

  std::size_t size() const noexcept { return size_; }
  /// Exact; 0 when there is none.
  std::uint64_t max_ns() const noexcept;
  /// The duration that `share` (0 to 1) of all durations do not exceed: the upper edge of its bucket, at most max_ns().
  /// 0 when there is none.
  std::uint64_t percentile_ns(double share) const noexcept;

 private:
  static constexpr unsigned kSubBits = 5;  // 32 buckets to the octave
  static constexpr unsigned kOctaves = 40;
  static constexpr std::size_t kBuckets = (kOctaves - kSubBits + 2) << kSubBits;

  static std::size_t bucket_of(std::uint64_t duration_ns) noexcept;
  static std::uint64_t upper_edge(std::size_t bucket) noexcept;

  std::array<std::uint64_t, kCapacity> durations_{};  // ring, ns
  std::array<std::uint16_t, kBuckets> counts_{};      // of durations_, by bucket
  std::size_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace tissued::daemon
