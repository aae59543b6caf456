// What the real-time step's elements get wrong at the markers, by small pushes of the body at rest: quadratic elements
// less its own. Not to be sold as missing physics.
#pragma once

#include <span>
#include <vector>

#include "core/rest_compliance.hpp"

namespace tissued::core {

class ElementError {
 public:
  // Above so many tetrahedra quadratic elements take too long: nothing is known of the error then.
  static constexpr int kMostTets = 8000;
  // Up to so many they are taken twice as fine.
  static constexpr int kMostRefinedTets = 700;

  // One factorisation of quadratic elements for every pad. compliance: of the model; holds no pad afterwards.
  ElementError(const Model& model, RestCompliance& compliance);

  bool known() const { return known_; }
  // mm, at a marker, under the pads: what each does alone, in proportion to how far it is pushed.
  Vec3 at(int marker, std::span<const PadInput> pads) const;

 private:
  std::vector<Vec3> pad_centers_;  // mm
  RowMatrix by_pad_;               // (3 pads x 3 markers) mm per mm that a pad moves along an axis
  bool known_ = false;
};

}  // namespace tissued::core
