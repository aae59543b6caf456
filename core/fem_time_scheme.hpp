// How finite elements step in time; see fem_dynamics.hpp.
#pragma once

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

}  // namespace tissued::core
