// Stress that relaxes: a deviatoric Prony series on the second Piola-Kirchhoff stress,
//   S = S_vol + (1 - g1 - g2) S_iso + g1 h1 + g2 h2,  h_i' = S_iso' - h_i / tau_i,
// so that the assumed modulus is the instantaneous one. A step takes S_iso to change linearly, then it is exact:
//   h' = e^(-dt/tau) h + (1 - e^(-dt/tau)) tau/dt (S_iso' - S_iso).
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// g1, tau1 s, g2, tau2 s.
const Effect& viscoelasticity_effect();

}  // namespace tissued::core
