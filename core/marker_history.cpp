#include "core/marker_history.hpp"

#include <algorithm>

namespace tissued::core {

MarkerHistory::MarkerHistory(std::size_t markers)
    : markers_(markers), places_(kFrames * markers, Vec3::Zero()), interval_(kFrames, 0.0) {}

void MarkerHistory::clear() { count_ = 0; }

void MarkerHistory::add(std::span<const Vec3> markers, double dt) {
  newest_ = (newest_ + 1) % kFrames;
  count_ = std::min(count_ + 1, kFrames);
  interval_[newest_] = dt;
  std::copy(markers.begin(), markers.end(), places_.begin() + static_cast<std::ptrdiff_t>(newest_ * markers_));
}

bool MarkerHistory::moved_since(double age, std::span<Vec3> moved) const {
  constexpr double kRounding = 1e-9;  // s
  if (!(age >= 0.0) || count_ == 0) return false;
  std::size_t back = 0;
  double left = age;  // s from the frame `back` to the time asked for
  while (back + 1 < count_ && left > interval_[slot(back)]) left -= interval_[slot(back++)];
  if (back + 1 == count_ && left > kRounding) return false;
  const double share = left > kRounding ? left / interval_[slot(back)] : 0.0;
  for (std::size_t i = 0; i < markers_; ++i) {
    const Vec3 then = share > 0.0 ? Vec3(at(back, i) + share * (at(back + 1, i) - at(back, i))) : at(back, i);
    moved[i] = at(0, i) - then;
  }
  return true;
}

}  // namespace tissued::core
