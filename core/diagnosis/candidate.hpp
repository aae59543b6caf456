// An explanation on trial: what it supposes, from where its fits begin, and how it fares.
#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/promises.hpp"

namespace tissued::core {

struct Candidate {
  std::vector<std::string> kinds;  // of the contract; empty: numbers only
  Hypothesis hypothesis;
  std::vector<Values> starts;     // at least one
  Fit fast, exact;                // linear elements corrected by quadratic ones; quadratic ones
  std::vector<Promise> promises;  // of the starts, where there were many

  std::string name() const;
  const Fit& best() const { return exact.solved ? exact : fast; }
};

// Only the assumed physics' own numbers.
Candidate numbers_candidate();
// Every effect that the session can show, every fault of measurement, one at a time.
std::vector<Candidate> single_candidates(const RecordedSession& session, const FitData& data, const Fit& numbers);
// Likewise of a session of motions; latency is not told from when a body was let go.
std::vector<Candidate> motion_candidates(const RecordedSession& session);
// One that was fitted and, added to it, another one with all of its starts.
Candidate extended(const Candidate& first, const Candidate& second);

// Numbers of a fit, to begin another one with; the share of discretisation is not among them, because it means another
// thing to elements of another kind.
Values values_of(const Fit& fit);

}  // namespace tissued::core
