// Tissue that takes up or loses volume everywhere: growth Jg = 1 + rate t since rest, F_e = F Jg^(-1/3). The elastic
// energy is per volume at rest, so that only its volumetric part changes: kappa/2 (J / Jg - 1)^2.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// rate 1/s; negative: it shrinks.
const Effect& swelling_effect();

}  // namespace tissued::core
