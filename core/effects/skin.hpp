// A stiff layer on the free surface, pads included: a membrane without bending, an incompressible neo-Hookean sheet in
// plane stress. With C the two-dimensional stretch tensor its energy per area is E h / 6 (tr C + 1 / det C - 3).
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// stiffness: E h, kPa mm.
const Effect& skin_effect();

}  // namespace tissued::core
