#pragma once

#include <string>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// report.html of `tissuectl diagnose`: one page that loads nothing and works from a file, on a phone and on paper.
/// What is wrong, how sure that is and where, the three models' misfit, alternatives, numbers, and what to record next.
/// Parts for which the diagnosis holds nothing are left out. scene: the bundle's, with the mesh of the mismatch map.
std::string diagnosis_page(const core::Diagnosis& diagnosis, const core::Scene& scene);

}  // namespace tissued::daemon
