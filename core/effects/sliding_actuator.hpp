// Pads that slide on the skin. No pad holds its nodes; springs over its area hold them to its moving pose, firm across
// the pad's plate and looser along it. The pad does not let go: it pulls as well as it pushes.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// slip (0: glued; 1: free along the plate), across (a switch: what is normal to the plate. 0: the mean normal of the
// pad's facets; 1: its push direction; 2: each facet's own normal).
const Effect& sliding_actuator_effect();

}  // namespace tissued::core
