#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tissued::daemon {

/// Durations, all of them kept, so that percentiles are exact. For one thread.
class DurationSample {
 public:
  void add(std::uint64_t duration_ns) { durations_.push_back(duration_ns); }
  std::size_t count() const { return durations_.size(); }

  /// ms; the smallest duration that `share` (0 to 1) of all do not exceed. 0 when there is none.
  double percentile_ms(double share) const;
  double max_ms() const { return percentile_ms(1.0); }

 private:
  std::vector<std::uint64_t> durations_;  // ns
};

}  // namespace tissued::daemon
