#include <catch2/catch.hpp>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/narrowing.hpp"
#include "core/diagnosis/second_explanation.hpp"
#include "tests/core/diagnosis/twin_session.hpp"

using namespace tissued::core;

namespace {

const testing::TwinTruth kRelaxing{{{"viscoelasticity.g1", 0.45}, {"viscoelasticity.tau1", 0.4}}, {"viscoelasticity"}};

SearchOptions within(double budget) {
  SearchOptions options;
  options.budget = budget;
  return options;
}

Candidate of_kind(const std::string& kind, const std::vector<Candidate>& candidates) {
  for (const Candidate& candidate : candidates)
    if (candidate.kinds.front() == kind) return candidate;
  throw std::out_of_range(kind);
}

// A search that found a gradient first, which may stand in for relaxation, and the pair of both.
SearchResult gradient_first(const RecordedSession& session) {
  SearchResult result;
  result.exact = fit_data(session, 3.0, FemElement::p2, error_model(session), nullptr);
  result.numbers = numbers_candidate();
  result.numbers.exact = fit(result.exact, result.numbers.hypothesis, {}, kExact);
  const std::vector<Candidate> all = single_candidates(session, result.exact, result.numbers.exact);
  Candidate gradient = of_kind("stiffness-gradient", all);
  gradient.exact = fit(result.exact, gradient.hypothesis, gradient.starts.front(), kExact);
  const Candidate relaxation = of_kind("viscoelasticity", all);
  Candidate pair = extended(gradient, relaxation);
  pair.exact = fit(result.exact, pair.hypothesis, pair.starts.front(), kExact);
  result.rounds = {{gradient, relaxation}, {pair}};
  REQUIRE(gain(result, pair, gradient) > kAcceptBeside);
  return result;
}

}  // namespace

TEST_CASE("a first explanation that only stood in for the second is not needed beside it", "[diagnosis]") {
  const RecordedSession session = testing::twin_session(kRelaxing, 1);
  const SearchResult found = gradient_first(session);
  const SearchOptions enough = within(1e4), none = within(0.0);
  Work in_time(enough), too_late(none);

  SearchResult refitted = found;
  CHECK(refit_halves(in_time, refitted));
  CHECK(refitted.rounds[0].front().name() == "viscoelasticity");
  CHECK(refitted.rounds[0].front().exact.value("viscoelasticity.g1") == Approx(0.45).margin(0.03));
  CHECK(gain(refitted, refitted.rounds[1].front(), refitted.rounds[0].front()) < kAcceptBeside);

  // The gradient may be as small as nothing.
  SearchResult stopped = found;
  REQUIRE(too_late.over());
  refit_halves(too_late, stopped);
  CHECK(stopped.rounds[0].front().name() == "viscoelasticity");
  CHECK_FALSE(stopped.rounds[1].front().exact.solved);
}

TEST_CASE("both halves of a pair stay where both are needed", "[diagnosis]") {
  testing::TwinTruth truth = kRelaxing;
  truth.effects.emplace_back("stiffness-gradient");
  truth.numbers.emplace_back("stiffness-gradient.slope.x", 0.03);
  const RecordedSession session = testing::twin_session(truth, 1);
  const SearchResult found = gradient_first(session);
  const SearchOptions enough = within(1e4), none = within(0.0);
  for (const SearchOptions* options : {&enough, &none}) {
    SearchResult result = found;
    Work work(*options);
    CHECK_FALSE(refit_halves(work, result));
    REQUIRE(result.rounds[1].front().exact.solved);
    CHECK(gain(result, result.rounds[1].front(), result.rounds[0].front()) > kAcceptBeside);
  }
}
