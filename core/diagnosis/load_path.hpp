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
  bool settles = false;        // of a motion: the step to here is a long one, which damps what swings
};

// What an answer at some instant is of the answers at the keys: a cubic through the nearest, which does not smooth over
// the instants at which pads begin or cease to move.
struct PathPlace {
  std::array<int, 4> keys{};
  std::array<double, 4> weights{};
};

// How a motion is stepped through.
struct MotionSteps {
  double finest = 0.005;  // s between keys while the body swings
  double window = 1e9;    // s after the release: no longer than that, or than it is seen to swing
  bool settles = true;    // then in long steps, which damp; false: as far as `window` even so
};

// Of the shortest period, between keys where a swing is followed to all frames.
inline constexpr double kFineStep = 1.0 / 26.0;

// A pad on its way from one input to another; of a pad that comes or goes the first.
PadInput between(const PadInput& a, const PadInput& b, double share);

class LoadPath {
 public:
  // travel: mm between keys while pads move.
  LoadPath(const RecordedTrial& trial, const Scene& scene, double travel);
  // Of a trial with a motion: keys in even steps of time. The trial must outlive the path.
  LoadPath(const RecordedTrial& trial, const Scene& scene, const MotionSteps& steps);

  const std::vector<LoadKey>& keys() const { return keys_; }
  std::size_t key_at_peak() const;  // the first of those with the largest load
  int pose_count() const { return pose_count_; }
  double peak_load() const { return peak_load_; }   // mm; of a motion: the largest displacement of a marker
  const Motion* motion() const { return motion_; }  // nullptr: equilibria
  // Whether answers are good at that time: while a body settles they are not, only where it has.
  bool shows(double time) const { return time <= swings_until_ + 1e-9 || time >= calm_from_ - 1e-9; }
  PathPlace place(double time) const;
  // mm, at any time of the trial.
  double load(double time) const;

 private:
  struct Frame {
    double time, load, coordinate;
  };
  void read_frames(const RecordedTrial& trial);
  void add_key(const RecordedTrial& trial, double time, bool is_kink);
  void number_poses();
  double coordinate(double time) const;

  const Scene* scene_;
  const Motion* motion_ = nullptr;
  double swings_until_ = 1e9, calm_from_ = 1e9;  // s
  std::vector<Frame> frames_;
  std::vector<LoadKey> keys_;
  std::vector<double> key_coordinates_;
  std::vector<std::uint8_t> is_kink_;  // (keys) the way changes there
  int pose_count_ = 1;
  double peak_load_ = 0.0;
};

}  // namespace tissued::core
