#pragma once

#include <nlohmann/json.hpp>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// report.json of `tissuectl diagnose`, format tissue-diagnosis/1: findings, alternatives and root mean squares per
/// axis (mm, N). What was not seen, and so is not finite, has no key; in a vector it is null. Beside the contract's
/// keys it holds `complete` (false: stopped before its end) and `remarks`.
nlohmann::json report_json(const core::Diagnosis& diagnosis);

}  // namespace tissued::daemon
