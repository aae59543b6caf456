// A part of the support that does not hold. The fixed nodes are let go and held by springs over the support's area, so
// firm that they give by less than 1e-4 mm; inside of a disc with a smooth edge the springs get loose, along the
// surface and, where normal_held is 0, across it as well.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// center.x, center.y, center.z mm, radius mm, looseness (0: it holds; 1: let go), normal_held (a switch, 0 or 1).
const Effect& loose_base_effect();

}  // namespace tissued::core
