// Where the simulated markers were in the frames before: markers that were seen a while ago are compared with the
// simulation of their own time.
#pragma once

#include <span>
#include <vector>

#include "core/types.hpp"

namespace tissued::core {

class MarkerHistory {
 public:
  explicit MarkerHistory(std::size_t markers);

  void clear();
  // The simulated markers of a new frame, (markers) mm; dt: s since the one before.
  void add(std::span<const Vec3> markers, double dt);
  // (markers) mm: what each has moved by in the simulation since `age` seconds before the newest frame; straight lines
  // between frames. False, and nothing written, where the history does not reach back so far.
  bool moved_since(double age, std::span<Vec3> moved) const;

  static constexpr std::size_t kFrames = 64;

 private:
  // `back` frames before the newest.
  std::size_t slot(std::size_t back) const { return (newest_ + kFrames - back) % kFrames; }
  const Vec3& at(std::size_t back, std::size_t marker) const { return places_[slot(back) * markers_ + marker]; }

  std::size_t markers_;
  std::vector<Vec3> places_;      // (frames x markers) mm
  std::vector<double> interval_;  // (frames) s since the frame before
  std::size_t newest_ = 0, count_ = 0;
};

}  // namespace tissued::core
