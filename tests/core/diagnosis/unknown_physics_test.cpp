// What the library has no name for must not be given one, and is to be found where it is.
#include "tests/core/diagnosis/unknown_physics.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/diagnosis/diagnosis.hpp"
#include "tests/core/diagnosis/twin_session.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

Diagnosis diagnosed(const RecordedSession& session) {
  SearchOptions options;
  options.refine_mesh = false;
  options.budget = 1e4;
  return diagnose(session, options);
}

// Of the markers, without noise, in units of noise.
double misfit(const Diagnosis& diagnosis, double noise) {
  return std::sqrt(std::pow(diagnosis.trials.assumed.marker_mm / noise, 2) - 1.0);
}

void check_unknown_near(const Diagnosis& diagnosis, const Vec3& truth) {
  CHECK(diagnosis.verdict == Verdict::unexplained);
  REQUIRE_FALSE(diagnosis.findings.empty());
  const Finding& finding = diagnosis.findings.front();
  CHECK(finding.kind == "unknown");
  CHECK(finding.probability > 0.9);
  REQUIRE(finding.where.has_value());
  CHECK((finding.where->center - truth).norm() < 10.0);
}

}  // namespace

TEST_CASE("a cavity that fills is not explained, and its place is found", "[diagnosis]") {
  const Vec3 center(18, 22, 17);
  const FluidCavity cavity(center, 12.0, 8.0);
  TwinTruth truth;
  truth.others = {&cavity};
  const Diagnosis diagnosis = diagnosed(twin_session(truth, 21));
  CHECK(misfit(diagnosis, truth.marker_noise) > 3.0);
  CHECK(misfit(diagnosis, truth.marker_noise) < 5.0);
  check_unknown_near(diagnosis, center);
}

TEST_CASE("a taut cable to the base is not explained, and its inner end is found", "[diagnosis]") {
  const Vec3 from(13, 20, 20), to(13, 20, 0);
  const InnerCable cable(from, to, 3.0, 6.0);
  TwinTruth truth;
  truth.others = {&cable};
  truth.marker_noise = 0.04;
  const Diagnosis diagnosis = diagnosed(twin_session(truth, 22));
  CHECK(misfit(diagnosis, truth.marker_noise) > 3.0);
  CHECK(misfit(diagnosis, truth.marker_noise) < 5.0);
  check_unknown_near(diagnosis, from);
}
