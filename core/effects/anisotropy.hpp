// Fibres: stiffer along an axis, in tension and in compression, by k/2 (I4bar - 1)^2 with I4bar = J^(-2/3) |F a|^2.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// k kPa, axis.x, axis.y, axis.z (of any length above 0; a and -a are the same).
const Effect& anisotropy_effect();

}  // namespace tissued::core
