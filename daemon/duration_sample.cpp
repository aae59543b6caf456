#include "daemon/duration_sample.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::daemon {

double DurationSample::percentile_ms(double share) const {
  if (durations_.empty()) return 0.0;
  const double rank = std::ceil(share * static_cast<double>(durations_.size()));
  const auto index = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(rank) - 1, 0, std::ssize(durations_) - 1);
  std::vector<std::uint64_t> sorted = durations_;
  std::nth_element(sorted.begin(), sorted.begin() + index, sorted.end());
  return static_cast<double>(sorted[static_cast<std::size_t>(index)]) * 1e-6;
}

}  // namespace tissued::daemon
