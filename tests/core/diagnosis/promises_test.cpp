#include <catch2/catch.hpp>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/candidate.hpp"
#include "core/diagnosis/narrowing.hpp"
#include "tests/core/diagnosis/twin_session.hpp"

using namespace tissued::core;

namespace {

const Candidate& named(const std::vector<Candidate>& all, const std::string& kind) {
  const auto at = std::find_if(all.begin(), all.end(), [&](const Candidate& c) { return c.kinds.front() == kind; });
  REQUIRE(at != all.end());
  return *at;
}

}  // namespace

TEST_CASE("a start that would have to go beyond a bound promises nothing", "[diagnosis]") {
  // Across these fibres the body is softer than its own numbers have it: fibres along other axes would have to weaken.
  const RecordedSession session = testing::twin_session({{{"youngs_modulus", 4.5},
                                                          {"anisotropy.k", 4.0},
                                                          {"anisotropy.axis.x", 0.4},
                                                          {"anisotropy.axis.y", 0.4},
                                                          {"anisotropy.axis.z", 0.8}},
                                                         {"anisotropy"}},
                                                        1);
  const FitData data = fit_data(session, 3.0, FemElement::p2, error_model(session), nullptr);
  const Fit numbers = fit(data, numbers_candidate().hypothesis, {}, kFast);
  const std::vector<Candidate> all = single_candidates(session, data, numbers);
  const Candidate& fibres = named(all, "anisotropy");
  const std::vector<Promise> promises = most_promising(data, fibres.hypothesis, fibres.starts);
  REQUIRE(promises.size() == fibres.starts.size());
  int beyond = 0;
  for (const Promise& promise : promises) {
    CHECK(promise.amplitude >= 0.0);
    CHECK(promise.gain >= 0.0);
    CHECK((promise.amplitude == 0.0) == (promise.gain == 0.0));
    if (promise.gain == 0.0) ++beyond;
  }
  CHECK(beyond > 0);
  REQUIRE(promises.front().gain > 0.0);
  Values start = fibres.starts[promises.front().start];
  set_amplitude(*fibres.hypothesis.effects.back(), promises.front().amplitude, start);
  const Fit found = fit(data, fibres.hypothesis, start, kExact);
  CHECK(found.value("anisotropy.k") == Approx(4.0).epsilon(0.2));
}

TEST_CASE("beside an effect a second one or a fault of measurement promises what its fit then gains", "[diagnosis]") {
  const auto [kind, truth] = GENERATE(table<std::string, testing::TwinTruth>({
      {"latency", {{{"gravity.gravity.y", 1.0}}, {"gravity"}, 0.06}},
      {"strain-stiffening",
       {{{"gravity.gravity.y", 1.0}, {"strain-stiffening.b", 5.0}}, {"gravity", "strain-stiffening"}}},
  }));
  CAPTURE(kind);
  const RecordedSession session = testing::twin_session(truth, 1);
  const FitData data = fit_data(session, 3.0, FemElement::p2, error_model(session), nullptr);
  const Fit numbers = fit(data, numbers_candidate().hypothesis, {}, kFast);
  const std::vector<Candidate> all = single_candidates(session, data, numbers);
  Candidate first = named(all, "gravity");
  first.fast = first.exact = fit(data, first.hypothesis, first.starts.front(), kExact);
  REQUIRE(first.exact.solved);
  Candidate pair = extended(first, named(all, kind));
  pair.fast = fit(data, pair.hypothesis, pair.starts.front(), kExact);
  REQUIRE(pair.fast.solved);
  const double promised = promise_beside(data, first, pair);
  CHECK(pair.exact.value("gravity.gravity.y") == first.exact.value("gravity.gravity.y"));
  const double gained = first.exact.chi_square - pair.fast.chi_square;
  REQUIRE(gained > 100.0);
  CHECK(promised > 0.2 * gained);
  CHECK(promised < 5.0 * gained);
}
