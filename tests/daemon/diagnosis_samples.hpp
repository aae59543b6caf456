// Invented diagnoses of the demo phantom, as the engine would return them: what a report has to show.
#pragma once

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

core::Scene demo_scene();

// A stiff lump between T1 and the pad A1, found and modelled; forces seen, one trial held out.
core::Diagnosis inclusion_sample(const core::Scene& scene);
// Noise alone: no map, no forces, a held-out recording that holds nothing but pads.
core::Diagnosis no_mismatch_sample(const core::Scene& scene);
// A place and a time, and no name.
core::Diagnosis unexplained_sample(const core::Scene& scene);

}  // namespace tissued::daemon
