// Tissue that gets stiffer as it stretches: the isochoric energy mu/2 (I1bar - 3) becomes mu/(2b) (exp(b (I1bar - 3)) -
// 1).
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// b, from 0 on.
const Effect& strain_stiffening_effect();

}  // namespace tissued::core
