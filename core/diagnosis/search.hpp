// The search for what is wrong: fits of ever fewer candidates by ever better models.
#pragma once

#include <functional>

#include "core/diagnosis/candidate.hpp"

namespace tissued::core {

struct SearchOptions {
  int threads = 0;              // 0: as many as there are processors
  double budget = 165.0;        // s; what is not done by then is left out, and said; a report comes within 3 min
  bool processor_time = false;  // the budget is of the processor's time per thread: other work does not cut it short
  bool refine_mesh = true;      // judge the elements by finer ones
  // share of the work done, 0 to 1, and what is being done; called from one thread at a time
  std::function<void(double, const std::string&)> progress;
  const std::atomic<bool>* interrupted = nullptr;
};

struct SearchResult {
  FitData coarse, fast, exact;  // linear elements on fewer keys, linear, quadratic elements
  Fit assumed;                  // nothing fitted, quadratic elements
  Candidate numbers;            // only numbers fitted
  // Candidates of one kind, of two, ...: most likely first; a round adds to the likeliest of the one before, where that
  // is accepted.
  std::vector<std::vector<Candidate>> rounds;
  bool compares_fast = false;  // candidates were compared by `fast` only: of motions `exact` takes too long
  bool complete = true;
  double discretisation_mm = 0.0;    // RMS of what finer elements say otherwise, markers at peak loads; 0: not judged
  double unjudged_mm = 0.0;          // what elements are taken to err that could not be judged
  std::vector<std::string> remarks;  // what a reader should know of how it was searched
};

// The session must outlive the result.
SearchResult search(const RecordedSession& session, const SearchOptions& options);

// What is said first needs that advantage over numbers alone; see the thresholds of diagnosis.cpp.
inline constexpr double kAccept = 20.0;
// What is said beside it gains that over the better half: elements err otherwise beside an effect than where they are
// judged. Of 36 sessions of scripts/prove with one thing missing (seeds 10101 to 10162) second ones that were not there
// gained up to 52, true ones 480 and more.
inline constexpr double kAcceptBeside = 80.0;
// Of a candidate of this round, from 0. Motions are judged by less (motion_search).
inline double least_gain(const SearchResult& result, std::size_t round) {
  return round == 0 || result.compares_fast ? kAccept : kAcceptBeside;
}

// Natural logarithm of how much likelier the recordings are under one candidate than under another that it adds to,
// whatever any single marker says: one that was placed wrongly near a pad can speak for anything. What noise and
// discretisation cannot account for is not taken for certain. -1e9 where one of them was not solved.
double gain(const SearchResult& result, const Candidate& with, const Candidate& without);

// Over numbers alone.
double advantage(const SearchResult& result, const Candidate& candidate);

// Linear elements preferred another one to what was chosen, which quadratic ones had no time for.
bool has_unheard_rival(const SearchResult& result, const Candidate& chosen);

}  // namespace tissued::core
