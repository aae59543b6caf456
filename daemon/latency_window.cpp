#include "daemon/latency_window.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tissued::daemon {

// Values below 2^(kSubBits + 1) have a bucket each; above, the leading kSubBits + 1 bits choose the bucket.
std::size_t LatencyWindow::bucket_of(std::uint64_t duration_ns) noexcept {
  const std::uint64_t value = std::min(duration_ns, std::uint64_t{1} << kOctaves);
  const auto width = static_cast<unsigned>(std::bit_width(value));
  const unsigned shift = width > kSubBits + 1 ? width - (kSubBits + 1) : 0;
  return (std::size_t{shift} << kSubBits) + static_cast<std::size_t>(value >> shift);
}

std::uint64_t LatencyWindow::upper_edge(std::size_t bucket) noexcept {
  const std::size_t shift = bucket < (2u << kSubBits) ? 0 : (bucket >> kSubBits) - 1;
  const std::uint64_t lead = bucket - (shift << kSubBits);
  return ((lead + 1) << shift) - 1;
}

void LatencyWindow::add(std::uint64_t duration_ns) noexcept {
  if (size_ == kCapacity) {
    --counts_[bucket_of(durations_[next_])];
  } else {
    ++size_;
  }
  durations_[next_] = duration_ns;
  ++counts_[bucket_of(duration_ns)];
  next_ = (next_ + 1) % kCapacity;
}

std::uint64_t LatencyWindow::max_ns() const noexcept {
  return size_ == 0 ? 0
                    : *std::max_element(durations_.begin(), durations_.begin() + static_cast<std::ptrdiff_t>(size_));
}

std::uint64_t LatencyWindow::percentile_ns(double share) const noexcept {
  if (size_ == 0) return 0;
  const auto rank = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(share * static_cast<double>(size_))));
  std::size_t below = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    below += counts_[bucket];
    if (below >= rank) return std::min(upper_edge(bucket), max_ns());
  }
  return max_ns();
}

}  // namespace tissued::daemon
