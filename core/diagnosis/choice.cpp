#include "core/diagnosis/choice.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnosis/comparison.hpp"

namespace tissued::core {

namespace {

// An effect is to take off more than the elements err, of the markers' misfit or, there in proportion, of the forces'.
bool matters(const SearchResult& result, const Candidate& with, const Candidate& without) {
  constexpr double kOfForces = 0.5;  // of their mean square
  if (!with.exact.solved || !without.exact.solved) return true;
  // Elements err alike on the way in and on the way out, a latency does not: what it takes off is not theirs.
  const bool adds_one = with.kinds.size() == without.kinds.size() + 1;
  if (adds_one && with.hypothesis.latency && !without.hypothesis.latency) return true;
  const Channels channels = channels_of(result.exact.session->scene);
  const auto misfit = [&](const Fit& fit) {
    return misfit_of(residuals_of(fit), channels, offset_of(result.exact, fit));
  };
  const Misfit before = misfit(without.exact), after = misfit(with.exact);
  const double elements = std::max(result.discretisation_mm, result.unjudged_mm);
  return std::pow(before.marker_mm, 2) - std::pow(after.marker_mm, 2) > std::pow(elements, 2) ||
         std::pow(after.force_N, 2) < kOfForces * std::pow(before.force_N, 2);
}

}  // namespace

const Candidate& chosen_of(const SearchResult& result) {
  const Candidate* chosen = &result.numbers;
  for (std::size_t r = 0; r < result.rounds.size() && !result.rounds[r].empty(); ++r) {
    const Candidate& before = r == 0 ? result.numbers : result.rounds[r - 1].front();
    double gain_of_chosen = 0.0;
    for (std::size_t k = chosen->kinds.size(); k <= r; ++k) gain_of_chosen += least_gain(result, k);
    const auto is_accepted = [&](const Candidate& candidate) {
      const auto is_better_than = [&](const Candidate& other, double least) {
        return gain(result, candidate, other) >= least && matters(result, candidate, other);
      };
      const bool is_judged = r == 0 || result.compares_fast || candidate.exact.solved;
      return is_judged && is_better_than(before, least_gain(result, r)) && is_better_than(*chosen, gain_of_chosen);
    };
    const auto accepted = std::find_if(result.rounds[r].begin(), result.rounds[r].end(), is_accepted);
    if (accepted != result.rounds[r].end()) chosen = &*accepted;
  }
  return *chosen;
}

Weights weigh(const SearchResult& result, const Candidate& chosen) {
  Weights weights{{&result.numbers, 0.0}};
  for (std::size_t r = 0; r < result.rounds.size(); ++r)
    for (const Candidate& candidate : result.rounds[r]) {
      const bool is_compared = result.compares_fast || candidate.exact.solved || !chosen.exact.solved;
      const Candidate& without = r == 0 ? result.numbers : result.rounds[r - 1].front();
      double odds = 0.0;
      for (std::size_t k = 0; k < candidate.kinds.size(); ++k) odds += least_gain(result, k);
      if (candidate.best().solved && is_compared && matters(result, candidate, without))
        weights.emplace_back(&candidate, advantage(result, candidate) - odds);
    }
  double best = 0.0, all = 0.0;
  for (const auto& weight : weights) best = std::max(best, weight.second);
  for (auto& weight : weights) all += weight.second = std::exp((weight.second - best) / kTemperature);
  for (auto& weight : weights) weight.second /= all;
  return weights;
}

double probability_of(const std::string& kind, const Weights& weights) {
  double with = 0.0;
  for (const auto& [candidate, weight] : weights)
    if (std::find(candidate->kinds.begin(), candidate->kinds.end(), kind) != candidate->kinds.end()) with += weight;
  return std::clamp(with, 1.0 - kSurest, kSurest);
}

}  // namespace tissued::core
