// Which of many places is worth a fit: what one linear step from each would gain.
#pragma once

#include <vector>

#include "core/diagnosis/fit.hpp"

namespace tissued::core {

// What a start promises.
struct Promise {
  std::size_t start = 0;    // index
  double chi_square = 0.0;  // after one step
  double gain = 0.0;        // of chi square, by the effect; infinite where it has no amplitude
  double amplitude = 0.0;   // of Effect::amplitude after that step; as it was where the effect has none
};

// Of several starts of the hypothesis' last effect, best first. Those without an equilibrium are left out.
std::vector<Promise> most_promising(const FitData& data, const Hypothesis& hypothesis,
                                    const std::vector<Values>& starts);

struct Candidate;
// Sets the promises, best first, of every one of `added`: candidates with all of the base's effects and one that it
// does not have. One evaluation for all; those of effects without an amplitude promise nothing here. Returns the least
// chi square among them.
double promise_all(const FitData& data, const Candidate& base, std::vector<Candidate>& added);

// What one linear step from the base's fit by quadratic elements would take off chi square, where this candidate adds
// its effect at the place that was found for it, or its fault of measurement. Leaves where it stepped from as the
// candidate's fit. Infinite without equilibrium.
double promise_beside(const FitData& exact, const Candidate& base, Candidate& candidate);

// Sets what is linear in an effect's start, where it has such a number.
void set_amplitude(const Effect& effect, double amplitude, Values& start);

}  // namespace tissued::core
