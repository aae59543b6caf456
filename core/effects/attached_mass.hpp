// Something heavy that moves with the tissue: a mass at a point of the body, with its inertia, and its weight where
// there is gravity.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// mass g, at.x, at.y, at.z mm, tissue; where that is outside of the body, the body's nearest point.
const Effect& attached_mass_effect();

}  // namespace tissued::core
