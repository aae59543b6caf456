// Weight along a direction that was not assumed.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// gravity.x, gravity.y, gravity.z in g0: the body's own weight (FemGravity), whose numbers become the effect's.
const Effect& gravity_effect();

}  // namespace tissued::core
