// How finite elements step in time; see fem_dynamics.hpp.
#pragma once

#include "core/fem_term.hpp"

namespace tissued::core {

struct TimeScheme {
  enum class Kind { implicit_euler, generalized_alpha };
  Kind kind = Kind::generalized_alpha;
  double spectral_radius = 0.8;  // in [0, 1]; 1: no numerical damping. Of generalized-alpha
};

// C = mass M + stiffness K(rest).
struct RayleighDamping {
  double mass = 0.0;       // 1/s
  double stiffness = 0.0;  // s
};

// Damping that a body has of itself, with numbers that can be set.
class FemDamping : public FemAdjustable {
 public:
  virtual RayleighDamping rates() const = 0;
};

}  // namespace tissued::core
