// The way that the pads go in a trial, by the few instants at which a body is solved for; between them answers are
// interpolated. Instants of a way back have the poses of the way there, so that an elastic body is solved once for
// both.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/diagnosis/session.hpp"

namespace tissued::core {

struct LoadKey {
  double time = 0.0;           // s
  std::vector<PadInput> pads;  // (pads)
  double load = 0.0;           // mm, of the pad that is furthest from its pose at rest
  int pose = 0;                // keys of equal pads share it; 0: at rest
};

// What an answer at some instant is of the answers at the keys: a cubic through the nearest, which does not smooth over
// the instants at which pads begin or cease to move.
struct PathPlace {
  std::array<int, 4> keys{};
  std::array<double, 4> weights{};
};

class LoadPath {
 public:
  // travel: mm between keys while pads move.
  LoadPath(const RecordedTrial& trial, const Scene& scene, double travel);

  const std::vector<LoadKey>& keys() const { return keys_; }
  int pose_count() const { return pose_count_; }
  double peak_load() const { return peak_load_; }  // mm
  PathPlace place(double time) const;
  // mm, at any time of the trial.
  double load(double time) const;

 private:
  struct Frame {
    double time, load, coordinate;
  };
  void add_key(const RecordedTrial& trial, double time, bool is_kink);
  void number_poses();
  double coordinate(double time) const;

  const Scene* scene_;
  std::vector<Frame> frames_;
  std::vector<LoadKey> keys_;
  std::vector<double> key_coordinates_;
  std::vector<std::uint8_t> is_kink_;  // (keys) the way changes there
  int pose_count_ = 1;
  double peak_load_ = 0.0;
};

}  // namespace tissued::core
