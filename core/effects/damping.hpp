// Motion that decays faster than the model says: Rayleigh damping C = alpha M + beta K(rest), beside what was assumed.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// alpha 1/s, beta s.
const Effect& damping_effect();

}  // namespace tissued::core
