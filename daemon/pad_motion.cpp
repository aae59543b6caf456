#include "daemon/pad_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tissued::daemon {
namespace {

constexpr std::array<std::string_view, 4> kNames{"in-turn", "together", "sway", "rest"};
constexpr double kRestBefore = 1.0;  // s

// A quarter of the period each: in, hold, out, rest.
double single_push(double phase) { return minimum_jerk(4.0 * phase) - minimum_jerk(4.0 * phase - 2.0); }

}  // namespace

double minimum_jerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

std::span<const std::string_view> push_pattern_names() { return kNames; }

std::optional<PushPattern> push_pattern_of(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<PushPattern>(found - kNames.begin());
}

double push_share(PushPattern pattern, std::size_t pad, std::size_t pads, double time, double period) {
  const double since = time - kRestBefore;
  if (since <= 0.0) return 0.0;
  const double pushes = since / period;
  switch (pattern) {
    case PushPattern::in_turn: {
      const bool its_turn = static_cast<std::size_t>(pushes) % pads == pad;
      return its_turn ? single_push(pushes - std::floor(pushes)) : 0.0;
    }
    case PushPattern::together:
      return single_push(pushes - std::floor(pushes));
    case PushPattern::sway: {
      const double begun = std::max(0.0, pushes - 0.25 * static_cast<double>(pad % 4));
      return 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * begun));
    }
    case PushPattern::rest:
      break;
  }
  return 0.0;
}

}  // namespace tissued::daemon
