// Recordings by a body of ours. The solver is the diagnosis' own, on the same mesh: what is tried here is the way from
// residuals to words. Recordings by others are in tests/daemon.
#include <catch2/catch.hpp>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/diagnosis.hpp"
#include "core/diagnosis/narrowing.hpp"
#include "tests/core/diagnosis/twin_session.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

SearchOptions quick() {
  SearchOptions options;
  options.refine_mesh = false;
  options.budget = 1e4;
  return options;
}

std::vector<std::string> kinds_of(const Diagnosis& diagnosis) {
  std::vector<std::string> kinds;
  for (const Finding& finding : diagnosis.findings) kinds.push_back(finding.kind);
  return kinds;
}

}  // namespace

TEST_CASE("nothing is found where nothing is missing", "[diagnosis]") {
  const Diagnosis diagnosis = diagnose(twin_session({}, 1), quick());
  CHECK(diagnosis.verdict == Verdict::no_mismatch);
  CHECK(diagnosis.findings.empty());
  CHECK(diagnosis.trials.assumed.marker_mm == Approx(0.1).epsilon(0.15));
}

TEST_CASE("other numbers are not sold as physics", "[diagnosis]") {
  const Diagnosis diagnosis =
      diagnose(twin_session({{{"youngs_modulus", 8.5}, {"poissons_ratio", 0.41}}, {}}, 2), quick());
  CHECK(diagnosis.verdict == Verdict::parameters);
  REQUIRE(kinds_of(diagnosis) == std::vector<std::string>{"parameters"});
  // What the elements may err in forces is allowed for, and stated.
  const FindingNumber &modulus = diagnosis.findings[0].parameters[0], &ratio = diagnosis.findings[0].parameters[1];
  CHECK(modulus.sd[0] < 0.05 * modulus.value[0]);
  CHECK(std::abs(modulus.value[0] - 8.5) < 3.0 * modulus.sd[0]);
  CHECK(ratio.value[0] == Approx(0.41).margin(0.01));
}

TEST_CASE("a body that has no equilibrium as it was assumed is diagnosed all the same", "[diagnosis]") {
  RecordedSession session = twin_session({{{"youngs_modulus", 8.5}}, {}}, 2);
  session.scene.material.poissons_ratio = 0.4995;  // too much for quadratic elements under these pads
  const Diagnosis diagnosis = diagnose(session, quick());
  CHECK(diagnosis.verdict == Verdict::parameters);
  CHECK(diagnosis.trials.explained.marker_mm < diagnosis.trials.assumed.marker_mm);
  REQUIRE_FALSE(diagnosis.remarks.empty());
  CHECK_THAT(diagnosis.remarks.front(), Catch::Contains("As assumed the body has no equilibrium on the way"));
}

TEST_CASE("relaxation is named, measured, and predicts what was held out", "[diagnosis]") {
  const TwinTruth truth{{{"youngs_modulus", 7.0}, {"viscoelasticity.g1", 0.45}, {"viscoelasticity.tau1", 0.4}},
                        {"viscoelasticity"}};
  const Diagnosis diagnosis = diagnose(twin_session(truth, 3), quick());
  CHECK(diagnosis.verdict == Verdict::missing_physics);
  REQUIRE_FALSE(diagnosis.findings.empty());
  const Finding& finding = diagnosis.findings.front();
  CHECK(finding.kind == "viscoelasticity");
  CHECK(finding.probability > 0.9);
  CHECK(finding.parameters[0].value[0] == Approx(0.45).margin(0.03));
  CHECK(finding.parameters[1].value[0] == Approx(0.4).epsilon(0.1));
  CHECK(diagnosis.held_out_seen);
  CHECK(diagnosis.held_out.explained.force_N < 0.2 * diagnosis.held_out.assumed.force_N);
}

TEST_CASE("a late stream is the measurement's fault", "[diagnosis]") {
  const Diagnosis diagnosis = diagnose(twin_session({{}, {}, 0.06}, 4), quick());
  CHECK(diagnosis.verdict == Verdict::measurement);
  REQUIRE(kinds_of(diagnosis) == std::vector<std::string>{"latency"});
  CHECK(diagnosis.findings[0].parameters[0].value[0] == Approx(0.06).margin(0.003));
}

TEST_CASE("a turned and shifted tracker is the measurement's fault", "[diagnosis]") {
  TwinTruth truth;
  truth.rotation = Vec3(0.0, 0.0, 0.035);  // 2 degrees
  truth.shift = Vec3(1.5, -1.0, 0.0);
  const Diagnosis diagnosis = diagnose(twin_session(truth, 7), quick());
  CHECK(diagnosis.verdict == Verdict::measurement);
  REQUIRE(kinds_of(diagnosis) == std::vector<std::string>{"registration"});
  const FindingNumber &rotation = diagnosis.findings[0].parameters.at(0),
                      &shift = diagnosis.findings[0].parameters.at(1);
  CHECK(rotation.name == "rotation");
  CHECK(rotation.unit == "deg");
  CHECK(rotation.value[2] == Approx(2.0).margin(0.3));
  CHECK(shift.name == "shift");
  CHECK(shift.value[0] == Approx(1.5).margin(0.4));
}

TEST_CASE("a marker that moved on the skin is the measurement's fault, and named", "[diagnosis]") {
  TwinTruth truth;
  truth.slips = {{3, 1, 0.5, Vec3(1.2, -0.8, 0.2)}};  // in the second trial, on the way in
  const RecordedSession session = twin_session(truth, 8);
  const Diagnosis diagnosis = diagnose(session, quick());
  CHECK(diagnosis.verdict == Verdict::measurement);
  REQUIRE(kinds_of(diagnosis) == std::vector<std::string>{"marker-slip"});
  REQUIRE(diagnosis.findings[0].parameters.size() == 1);
  const FindingNumber& slip = diagnosis.findings[0].parameters[0];
  CHECK(slip.name == session.scene.markers[3].name);
  CHECK(slip.value[0] == Approx(1.2).margin(0.15));
  CHECK(slip.value[1] == Approx(-0.8).margin(0.15));
}

TEST_CASE("a search that is interrupted says so and still reports", "[diagnosis]") {
  std::atomic<bool> interrupted{false};
  SearchOptions options = quick();
  options.interrupted = &interrupted;
  options.progress = [&interrupted](double share, const std::string&) {
    if (share > 0.33) interrupted = true;
  };
  const Diagnosis diagnosis = diagnose(twin_session({{{"youngs_modulus", 8.0}}, {}}, 5), options);
  CHECK_FALSE(diagnosis.complete);
  CHECK_FALSE(diagnosis.remarks.empty());
}

TEST_CASE("a search that is stopped before it found anything does not say that there is nothing", "[diagnosis]") {
  SearchOptions options = quick();
  std::atomic<bool> interrupted{false};
  options.interrupted = &interrupted;
  options.progress = [&interrupted](double share, const std::string&) { interrupted = share > 0.29; };
  const Diagnosis diagnosis = diagnose(twin_session({{{"gravity.gravity.x", 1.5}}, {"gravity"}}, 9), options);
  REQUIRE_FALSE(diagnosis.complete);
  CHECK(diagnosis.trials.explained.marker_mm > 1.3 * diagnosis.noise_marker_mm);
  CHECK(diagnosis.verdict == Verdict::unexplained);
}

TEST_CASE("what a stopped search found is no finding where it leaves most of the misfit", "[diagnosis]") {
  // Markers err by what is in proportion to the load: elements might, so that no structure is left.
  RecordedSession session = twin_session({}, 11);
  SearchResult result;
  result.exact = fit_data(session, 3.0, FemElement::p2, error_model(session), nullptr);
  result.exact.errors.discretisation.setConstant(1.0);
  Hypothesis nothing;
  nothing.numbers = false;
  const Fit load_seen = assess(result.exact, nothing);
  const int markers = channels_of(session.scene).markers;
  for (const TrialResidual& trial : load_seen.residuals)
    for (int c = 0; c < 3 * markers; ++c)
      session.trials[static_cast<std::size_t>(trial.trial)].seen.col(c) += (c % 2 == 0 ? 0.5 : -0.5) * trial.load;
  result.assumed = assess(result.exact, nothing);
  result.numbers = numbers_candidate();
  result.numbers.exact = fit(result.exact, result.numbers.hypothesis, {}, kExact);
  for (Candidate& candidate : single_candidates(session, result.exact, result.numbers.exact))
    if (candidate.kinds.front() == "gravity") result.rounds = {{std::move(candidate)}};
  Candidate& little = result.rounds.at(0).at(0);
  little.exact = fit(result.exact, little.hypothesis, little.starts.front(), kExact);
  little.exact.log_evidence = result.numbers.exact.log_evidence + 500.0;
  little.exact.residuals = result.numbers.exact.residuals;
  for (TrialResidual& trial : little.exact.residuals) trial.residual *= 0.95;

  const Diagnosis complete = conclude(session, result, 1);
  REQUIRE(complete.grounds.structure < 1.5);
  CHECK(kinds_of(complete) == std::vector<std::string>{"gravity"});
  result.complete = false;
  const Diagnosis stopped = conclude(session, result, 1);
  CHECK(stopped.verdict == Verdict::unexplained);
  CHECK(kinds_of(stopped) == std::vector<std::string>{"unknown"});
  CHECK(stopped.findings.front().probability == 0.5);
  REQUIRE_FALSE(stopped.alternatives.empty());
  CHECK(stopped.alternatives.front().kind == "gravity");
  CHECK(stopped.alternatives.front().probability <= 0.5);
  CHECK_THAT(stopped.next_experiment, Catch::Contains("To see whether it is gravity after all"));
}

TEST_CASE("a diagnosis is the same for any number of threads", "[diagnosis]") {
  const RecordedSession session = twin_session({{{"gravity.gravity.x", 0.5}}, {"gravity"}}, 6);
  SearchOptions one = quick(), two = quick();
  one.threads = 1;
  two.threads = 2;
  const Diagnosis a = diagnose(session, one), b = diagnose(session, two);
  CHECK(kinds_of(a) == kinds_of(b));
  REQUIRE_FALSE(a.findings.empty());
  CHECK(a.findings.front().kind == "gravity");
  CHECK(a.explained.best().log_evidence == b.explained.best().log_evidence);
  CHECK(a.findings.front().parameters.front().value == b.findings.front().parameters.front().value);
}
