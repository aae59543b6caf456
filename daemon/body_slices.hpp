#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// Three cuts through the body at rest, across z, y and x at `through` (mm, tissue), as SVG: the mismatch in bands, the
/// outline with pads and base, targets near the cut, and the places of the findings. Empty panels where a cut misses
/// the body. mismatch: of mismatch_at_nodes, not empty.
std::string body_slices(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::vector<double>& mismatch,
                        const core::Vec3& through);

}  // namespace tissued::daemon
