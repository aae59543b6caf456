#pragma once

#include <array>
#include <cstdint>

namespace tissued::daemon {

/// What is left out while steps take longer than frames leave time for: iterations first, then meshes. A level higher
/// when a quarter of a second of steps has filled nine tenths of its frames' time, a level lower when five seconds of
/// them would fill less than seven tenths with the iterations of the level below.
class OverloadRule {
 public:
  static constexpr int kLevels = 6;

  /// iterations: of a step as configured.
  explicit OverloadRule(int iterations) : iterations_(iterations) {}

  /// A step that took so long, of a frame that came so long after the one before.
  void note(double step_s, double frame_s);

  int level() const { return level_; }
  /// Of the next step; 0: as configured.
  int max_iterations() const;
  /// Of so many meshes that are due, one is sent.
  static unsigned mesh_divisor(int level) { return 1U << (level > kLastShortening ? level - kLastShortening : 0); }

 private:
  static constexpr int kLastShortening = 3;  // levels beyond it send fewer meshes

  int iterations_at(int level) const;
  void begin_window() { busy_s_ = frames_s_ = 0.0; }

  int iterations_;
  int level_ = 0;
  double busy_s_ = 0.0, frames_s_ = 0.0;  // of the window at hand
  double calm_s_ = 0.0;                   // of windows since the last that was not calm
};

}  // namespace tissued::daemon
