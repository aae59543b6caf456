// What is said of a kind of finding that is not a physical effect, and what to record to see a kind better.
#pragma once

#include <string>
#include <string_view>

#include "core/diagnosis/fit.hpp"

namespace tissued::core {

std::string_view title_of(const std::string& kind);
// With the numbers of the fit.
std::string summary_of(const std::string& kind, const Fit& fit, const Scene& scene);
// What recording shows this kind most clearly.
std::string_view experiment_for(const std::string& kind);

}  // namespace tissued::core
