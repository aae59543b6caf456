// Ever fewer candidates, looked at by ever better models.
#pragma once

#include <vector>

#include "core/diagnosis/work.hpp"

namespace tissued::core {

inline constexpr FitControl kFast{16, 3.0}, kExact{12, 0.5};
inline constexpr std::size_t kStartsToFit = 3;

// What plots do not need of the candidates that lost.
void shed(Fit& fit);

// Against what the base of them all reaches.
class Narrowing {
 public:
  // base: evidence by linear elements on few and on all keys of what every candidate adds to. All outlive this.
  Narrowing(const FitData& coarse, const FitData& fast, const FitData& exact, const Candidate& base, Work& work);

  // From the share `from` of all work to `to`. False, and nothing is tried, where linear elements have no answer to
  // what every candidate adds to. Most likely first then.
  bool run(std::vector<Candidate>& candidates, std::size_t most_exact, double from, double to);

 private:
  // By quadratic elements, those that may add to the base what it takes to be said.
  void keep_promising(std::vector<Candidate*>& chosen, double from, double to);
  // Those worth more work: at most so many, with this share of the largest advantage.
  std::vector<Candidate*> best_of(std::vector<Candidate>& candidates, std::size_t most, double share) const;

  const FitData *coarse_, *fast_, *exact_;
  const Candidate* base_;
  Work* work_;
  bool has_base_ = false;
  double on_coarse_ = 0.0, on_fast_ = 0.0;
};

// That there was no Narrowing.
void say_untried(const char* what, const Work& work, SearchResult& result);

}  // namespace tissued::core
