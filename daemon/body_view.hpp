#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// The body as HTML with a script: a canvas that mouse, touch and keys turn, with the mismatch inside, pads, targets,
/// markers with their measured and predicted displacements in a trial, and the places of the findings. One per page.
/// Draws itself once the page is loaded, needs nothing from elsewhere. mismatch: of mismatch_at_nodes; may be empty.
std::string body_view(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::vector<double>& mismatch);

}  // namespace tissued::daemon
