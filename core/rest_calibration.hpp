// From tracker to tissue coordinates: a rigid registration from markers at rest, and the offset of every marker from
// the place it was said to be glued to.
#pragma once

#include <span>
#include <vector>

#include "core/rigid_transform.hpp"
#include "core/types.hpp"

namespace tissued::core {

struct Registration {
  RigidTransform tissue_from_tracker;
  double residual_rms = 0.0;  // mm per point (not per axis), after the fit
  double residual_max = 0.0;  // mm
  int points = 0;
  bool determined = false;  // at least three points, not on a line
};

// Least-squares rotation and translation, no scale (Umeyama 1991; Kabsch 1976), that takes `from` to `to`.
Registration register_rigid(std::span<const Vec3> from, std::span<const Vec3> to);

// Collects marker frames at rest. Allocates at construction only.
class RestCalibration {
 public:
  // rest: (m) mm, tissue, where the markers were said to be. placement_sd: mm per axis, how well they were placed.
  // noise_sd: mm per axis of one sample. initial: what is known of the registration beforehand (axes, say).
  // fit_rigid: false keeps `initial` and only learns offsets.
  RestCalibration(std::vector<Vec3> rest, double placement_sd, double noise_sd, RigidTransform initial, bool fit_rigid);

  // One frame at rest, tracker coordinates, sized (m).
  void add(std::span<const Vec3> markers, std::span<const std::uint8_t> seen);
  void reset();

  int frames() const { return frames_; }
  const Registration& registration() const { return registration_; }
  // Tissue position of a measured marker with its placement offset taken off: comparable to the rest position.
  Vec3 to_model(int marker, const Vec3& tracker_position) const;
  // mm, tissue: estimated offset of a marker from its said place, shrunk by its prior.
  const Vec3& offset(int marker) const { return offsets_[marker]; }
  bool has_offset(int marker) const { return counts_[marker] > 0; }
  // mm per axis, to which a marker's place is known that was seen in all frames so far.
  double place_sd() const;

 private:
  void refit();

  std::vector<Vec3> rest_;
  std::vector<Vec3> sums_;  // tracker
  std::vector<int> counts_;
  std::vector<Vec3> offsets_;  // tissue
  std::vector<Vec3> from_, to_;
  double placement_variance_, noise_variance_;
  RigidTransform initial_;
  bool fit_rigid_;
  int frames_ = 0;
  Registration registration_;
};

}  // namespace tissued::core
