// The figures and tables of a diagnosis, as HTML. Each is empty where there is nothing to show.
#pragma once

#include <string>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// The marker misfit of the three models as bars beside the noise: on held-out trials where they were seen, else on
/// those that were fitted.
std::string misfit_bars(const core::Diagnosis& diagnosis);

/// Marker misfit over time, a panel per trial: three models, the noise, and the load as a shade.
std::string misfit_courses(const core::Diagnosis& diagnosis);

/// The largest pad force over time, seen and as two models have it, a panel per trial with forces.
std::string force_courses(const core::Diagnosis& diagnosis);

/// Root mean squares of the three models, on fitted and on held-out trials.
std::string misfit_table(const core::Diagnosis& diagnosis);

/// Findings and alternatives by probability, as bars.
std::string probability_bars(const core::Diagnosis& diagnosis);

/// The numbers that were found, with their uncertainty.
std::string number_table(const core::Diagnosis& diagnosis);

}  // namespace tissued::daemon
