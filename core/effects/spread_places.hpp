// Places over a body, far from one another: where a search for a place begins.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "core/types.hpp"

namespace tissued::core {

// At most `count` of the points, each as far as can be from those before it; the first is the nearest to their middle.
inline std::vector<Vec3> spread_places(const std::vector<Vec3>& points, std::size_t count) {
  std::vector<Vec3> places;
  if (points.empty()) return places;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& point : points) middle += point / static_cast<double>(points.size());
  std::vector<double> distance;
  for (const Vec3& point : points) distance.push_back(-(point - middle).squaredNorm());
  while (places.size() < std::min(count, points.size())) {
    const auto furthest = std::max_element(distance.begin(), distance.end());
    const Vec3 place = points[static_cast<std::size_t>(furthest - distance.begin())];
    if (places.empty()) distance.assign(points.size(), std::numeric_limits<double>::infinity());
    places.push_back(place);
    for (std::size_t i = 0; i < points.size(); ++i)
      distance[i] = std::min(distance[i], (points[i] - place).squaredNorm());
  }
  return places;
}

}  // namespace tissued::core
