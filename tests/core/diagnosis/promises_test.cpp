#include <catch2/catch.hpp>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/candidate.hpp"
#include "core/diagnosis/narrowing.hpp"
#include "tests/core/diagnosis/twin_session.hpp"

using namespace tissued::core;

TEST_CASE("a start that would have to go beyond a bound promises nothing", "[diagnosis]") {
  // Across these fibres the body is softer than its own numbers have it: fibres along other axes would have to weaken.
  const RecordedSession session = testing::twin_session(
      {{{"youngs_modulus", 4.5}, {"anisotropy.k", 4.0}, {"anisotropy.axis.x", 0.4}, {"anisotropy.axis.y", 0.4},
        {"anisotropy.axis.z", 0.8}},
       {"anisotropy"}},
      1);
  const FitData data = fit_data(session, 3.0, FemElement::p2, error_model(session), nullptr);
  const Fit numbers = fit(data, numbers_candidate().hypothesis, {}, kFast);
  const std::vector<Candidate> all = single_candidates(session, data, numbers);
  const auto fibres =
      std::find_if(all.begin(), all.end(), [](const Candidate& c) { return c.kinds.front() == "anisotropy"; });
  REQUIRE(fibres != all.end());
  const std::vector<Promise> promises = most_promising(data, fibres->hypothesis, fibres->starts);
  REQUIRE(promises.size() == fibres->starts.size());
  int beyond = 0;
  for (const Promise& promise : promises) {
    CHECK(promise.amplitude >= 0.0);
    CHECK(promise.gain >= 0.0);
    CHECK((promise.amplitude == 0.0) == (promise.gain == 0.0));
    if (promise.gain == 0.0) ++beyond;
  }
  CHECK(beyond > 0);
  REQUIRE(promises.front().gain > 0.0);
  Values start = fibres->starts[promises.front().start];
  set_amplitude(*fibres->hypothesis.effects.back(), promises.front().amplitude, start);
  const Fit found = fit(data, fibres->hypothesis, start, kExact);
  CHECK(found.value("anisotropy.k") == Approx(4.0).epsilon(0.2));
}
