// Stiffness that varies smoothly along an axis: all moduli times exp(k axis . X), X from the origin of the tissue's
// frame. Fitted as the vector slope = k axis, in which it is linear and of which no direction is special.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// slope.x, slope.y, slope.z 1/mm. Reported as k and axis.
const Effect& stiffness_gradient_effect();

}  // namespace tissued::core
