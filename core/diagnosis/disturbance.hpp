// Where something pushes, pulls or swells that no effect has a name for: the force, or the pressure, at one place of
// the body that would repair most of what the markers show beside the model.
#pragma once

#include "core/diagnosis/finding.hpp"

namespace tissued::core {

// fit: of the assumed physics' numbers. of_tet: share of the markers' misfit that a disturbance there would explain, of
// the largest. Empty where nothing can be said: no marker seen, no equilibrium.
MismatchMap disturbance_map(const FitData& data, const Fit& fit);

}  // namespace tissued::core
