// What a diagnosis says, in words for a person. All of it is HTML: names from the bundle are escaped.
#pragma once

#include <string>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// `97 %`; at the ends `over 99 %` and `under 0.1 %`, a dash where it is not finite.
std::string percent_text(double probability);

/// What kind of verdict it is, in a few words.
std::string verdict_text(const core::Diagnosis& diagnosis);

/// What is wrong, in one sentence.
std::string headline(const core::Diagnosis& diagnosis);

/// How sure that is, in one sentence: of the likeliest fault where none was found.
std::string sureness_text(const core::Diagnosis& diagnosis);

/// Where a finding lies: coordinates, depth below the skin, the pad and the target that are nearest. Empty where it has
/// no place.
std::string place_text(const core::Finding& finding, const core::Scene& scene);

/// When a finding shows: trials and phase. Empty where nothing is known of it.
std::string time_text(const core::Finding& finding);

/// A kind of the contract, or several joined by " + ", with its plain words where it is an effect.
std::string kind_text(const std::string& kind);

/// `4.2 ± 0.7`, with the digits that the standard deviation leaves a meaning; components of a vector parted by commas.
std::string number_text(const core::FindingNumber& number);

}  // namespace tissued::daemon
