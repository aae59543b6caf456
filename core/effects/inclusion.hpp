// A lump of other stiffness: all moduli times exp(log(ratio) s), s falling from 1 to 0 across the edge of a ball whose
// weight is that of a sharp one of the given radius.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// center.x, center.y, center.z mm, tissue; radius mm; ratio.
const Effect& inclusion_effect();

}  // namespace tissued::core
