// No missing physics: the tissue's own numbers are other than assumed.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core {

// youngs_modulus kPa, poissons_ratio, density g/cm3: those of the body, under the effect's names.
const Effect& parameters_effect();

}  // namespace tissued::core
