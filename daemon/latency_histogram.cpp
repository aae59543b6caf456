#include "daemon/latency_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tissued::daemon {

// Values below 2^(kSubBits + 1) have a bucket each; above, the leading kSubBits + 1 bits choose the bucket.
std::size_t LatencyHistogram::bucket_of(std::uint64_t duration_ns) noexcept {
  const std::uint64_t value = std::min(duration_ns, std::uint64_t{1} << kOctaves);
  const auto width = static_cast<unsigned>(std::bit_width(value));
  const unsigned shift = width > kSubBits + 1 ? width - (kSubBits + 1) : 0;
  return (std::size_t{shift} << kSubBits) + static_cast<std::size_t>(value >> shift);
}

std::uint64_t LatencyHistogram::upper_edge(std::size_t bucket) noexcept {
  const std::size_t shift = bucket < (2u << kSubBits) ? 0 : (bucket >> kSubBits) - 1;
  const std::uint64_t lead = bucket - (shift << kSubBits);
  return ((lead + 1) << shift) - 1;
}

void LatencyHistogram::add(std::uint64_t duration_ns) noexcept {
  buckets_[bucket_of(duration_ns)].fetch_add(1, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  // One writer: no other thread can have raised the maximum in between.
  if (duration_ns > max_.load(std::memory_order_relaxed)) max_.store(duration_ns, std::memory_order_relaxed);
}

std::uint64_t LatencyHistogram::percentile_ns(double share) const noexcept {
  const std::uint64_t total = count();
  if (total == 0) return 0;
  const auto rank =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total))));
  std::uint64_t below = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    below += buckets_[bucket].load(std::memory_order_relaxed);
    if (below >= rank) return std::min(upper_edge(bucket), max_ns());
  }
  return max_ns();
}

}  // namespace tissued::daemon
