// What was recorded in a session, in tissue coordinates: what pushed the body, and what was seen of it.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/modal_covariance.hpp"
#include "core/scene.hpp"
#include "core/simulator.hpp"

namespace tissued::core {

// What is seen, one scalar a channel: the displacements of markers and of targets from the places that the scene
// states (mm), then the forces of pads on the tissue (N), x, y and z of each.
struct Channels {
  int markers = 0, targets = 0, pads = 0;

  int count() const { return 3 * (markers + targets + pads); }
  int of_marker(int marker, int axis = 0) const { return 3 * marker + axis; }
  int of_target(int target, int axis = 0) const { return 3 * (markers + target) + axis; }
  int of_force(int pad, int axis = 0) const { return 3 * (markers + targets + pad) + axis; }
  bool is_marker(int channel) const { return channel < 3 * markers; }
  bool is_force(int channel) const { return channel >= 3 * (markers + targets); }
};

inline Channels channels_of(const Scene& scene) {
  return {static_cast<int>(scene.markers.size()), static_cast<int>(scene.targets.size()),
          static_cast<int>(scene.pads.size())};
}

// Of a trial in which inertia matters.
struct Motion {
  double release = 0.0;  // s; the body is held before and free after
  bool held_undeformed =
      false;  // until then: in the shape of the mesh, whatever its weight; else as loads would have it
  std::vector<EdgeLoad> loads;  // that act once it is free
};

struct RecordedTrial {
  std::string name;
  std::vector<double> time;                 // (frames) s, ascending
  std::vector<std::vector<PadInput>> pads;  // (frames) (pads): without noise, without delay
  RowMatrix seen;                           // (frames x channels); NaN where nothing was
  std::optional<Motion> motion = {};        // none: the body is in equilibrium with its pads all the time

  int frame_count() const { return static_cast<int>(time.size()); }
};

struct RecordedSession {
  Scene scene;                                                        // the assumed physics
  double marker_noise = 0.1, target_noise = 0.3, force_noise = 0.01;  // mm, mm, N; stated standard deviations per axis
  std::vector<RecordedTrial> trials, held_out;

  bool is_dynamic() const { return !trials.empty() && trials.front().motion.has_value(); }
  double noise_of(int channel) const {
    const Channels channels = channels_of(scene);
    return channels.is_force(channel) ? force_noise : channels.is_marker(channel) ? marker_noise : target_noise;
  }
};

}  // namespace tissued::core
