#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace tissued::daemon {

/// How the pads of a simulated session move. All begin with a second at rest.
enum class PushPattern {
  in_turn,   ///< one after the other: in, hold, out, rest
  together,  ///< all at once: in, hold, out, rest
  sway,      ///< each to and fro, a quarter of a period behind the one before
  rest,      ///< not at all
};

/// From 0 to 1 with velocity and acceleration zero at both ends: what an actuator's controller would do.
double minimum_jerk(double s);

/// Names as in the enumeration, with `-` for `_`.
std::span<const std::string_view> push_pattern_names();
/// nullopt for a name that there is not.
std::optional<PushPattern> push_pattern_of(std::string_view name);

/// How far pad `pad` of `pads` is pushed at `time`, in shares of the full push: 0 to 1, with continuous velocity.
/// `period` is the time of one push, in to rest.
double push_share(PushPattern pattern, std::size_t pad, std::size_t pads, double time, double period);

}  // namespace tissued::daemon
