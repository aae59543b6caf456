#include "daemon/overload_rule.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::daemon {
namespace {

constexpr double kWindow = 0.25;  // s
constexpr double kTooBusy = 0.9;  // share of the frames' time
constexpr double kWouldBeCalm = 0.7;
constexpr double kCalmFor = 5.0;                              // s, before a level is left
constexpr std::array<double, 4> kShares{1.0, 0.7, 0.5, 0.3};  // of the iterations, by level

}  // namespace

int OverloadRule::iterations_at(int level) const {
  const double share = kShares[static_cast<std::size_t>(std::min(level, kLastShortening))];
  return std::max(1, static_cast<int>(std::lround(share * iterations_)));
}

int OverloadRule::max_iterations() const { return level_ == 0 ? 0 : iterations_at(level_); }

void OverloadRule::note(double step_s, double frame_s) {
  busy_s_ += step_s;
  frames_s_ += frame_s;
  if (frames_s_ < kWindow) return;
  const double busy = busy_s_ / frames_s_;
  if (busy > kTooBusy) {
    level_ = std::min(level_ + 1, kLevels);
    calm_s_ = 0.0;
  } else if (level_ > 0) {
    const double below = busy * iterations_at(level_ - 1) / iterations_at(level_);
    calm_s_ = below < kWouldBeCalm ? calm_s_ + frames_s_ : 0.0;
    if (calm_s_ >= kCalmFor) {
      --level_;
      calm_s_ = 0.0;
    }
  }
  begin_window();
}

}  // namespace tissued::daemon
