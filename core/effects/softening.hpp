// Mullins' effect after Ogden and Roxburgh: tissue that was strained once is weaker. The isochoric stress is multiplied
// by
//   eta = 1 - erf((Wmax - W) / w0) / r,
// where W is the isochoric energy mu/2 (I1bar - 3) and Wmax the largest that the point has seen.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// inverse_r (1/r; 0: absent), w0 kPa. Reported as r and w0.
const Effect& softening_effect();

}  // namespace tissued::core
