// Which of the candidates that a search has fitted is believed, and how much.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/diagnosis/search.hpp"

namespace tissued::core {

// Nobody who has seen some dozens of cases may be surer.
inline constexpr double kSurest = 0.98;

// The candidate that is believed: numbers alone, one effect, or more. A round adds to the likeliest of the one before,
// which need not matter alone: an effect may show itself only beside another one. Of the result.
const Candidate& chosen_of(const SearchResult& result);

using Weights = std::vector<std::pair<const Candidate*, double>>;

// Candidates that were looked at as closely as the chosen one, and how probable each is of them. An effect has the odds
// against it that it takes to be accepted: nulls have some advantage, too.
Weights weigh(const SearchResult& result, const Candidate& chosen);

// Of all that name it; at most kSurest, at least as much below one.
double probability_of(const std::string& kind, const Weights& weights);

}  // namespace tissued::core
