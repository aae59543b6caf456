// Places with an edge that is smooth enough to be fitted, over some 4 mm.
#pragma once

#include <cmath>
#include <numbers>

namespace tissued::core {

inline constexpr double kEdgeWidth = 1.0;  // mm; from 12 % to 88 % it is four times as much

// 1 inside, 1/2 at the edge, 0 outside.
inline double smooth_inside(double distance, double radius) {
  constexpr double kFar = 40.0;  // widths, beyond which there is nothing left
  if (distance - radius > kFar * kEdgeWidth) return 0.0;
  return 1.0 / (1.0 + std::exp((distance - radius) / kEdgeWidth));
}

// The radius at which a smooth ball weighs as much as a sharp one of the given radius: the root of
// r^3 + (pi w)^2 r = radius^3, exact but for exp(-radius / w).
inline double smooth_ball_radius(double radius) {
  const double p = std::numbers::pi * kEdgeWidth * std::numbers::pi * kEdgeWidth, q = radius * radius * radius;
  const double root = std::sqrt(q * q / 4.0 + p * p * p / 27.0);
  return std::cbrt(q / 2.0 + root) + std::cbrt(q / 2.0 - root);
}

}  // namespace tissued::core
