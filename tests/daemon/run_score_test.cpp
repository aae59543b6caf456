// Scores against what a pocket calculator says.
#include "daemon/run_score.hpp"

#include <catch2/catch.hpp>

#include "tests/daemon/recording_samples.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

// The sample's bundle with one target, whose sensor has a noise of 1 mm.
config::Bundle one_target_bundle() {
  config::Bundle bundle = sample_bundle();
  bundle.scene.targets.resize(1);
  bundle.noise.target = 1.0;
  return bundle;
}

const config::Bundle bundle = one_target_bundle();
const Recording recording(bundle, bundle.trials.front(), sample_trial());

// A run over the whole recording whose answers are `error` away from the measurement along x.
TrialRun run_with_errors(const std::vector<double>& errors) {
  TrialRun run;
  for (std::size_t i = 0; i < recording.frame_count(); ++i) {
    const core::Vec3 measured = recording.target(i, 0).value();
    RunFrame frame;
    frame.index = i;
    frame.contact = true;
    frame.step_time_ns = (i + 1) * 1'000'000;
    frame.targets.push_back({measured + core::Vec3(errors[i % errors.size()], 0, 0), {}, measured});
    run.push_back(frame);
  }
  return run;
}

void claim(TrialRun& run, double variance) {
  for (RunFrame& frame : run) frame.targets[0].covariance = {variance, 0, 0, variance, 0, variance};
}

}  // namespace

TEST_CASE("Errors of a run are means over its frames") {
  const RunScore score = score_run(bundle, recording, run_with_errors({1, -2, 3}));
  REQUIRE(score.targets.size() == 1);
  const TargetScore& target = score.targets[0];
  CHECK(target.name == "T1");
  CHECK(target.frames == 60);
  CHECK(target.mean_mm == Approx(2.0));
  CHECK(target.rms_mm == Approx(std::sqrt((1.0 + 4.0 + 9.0) / 3.0)));
  CHECK(target.p95_mm == Approx(3.0));
  CHECK(target.max_mm == Approx(3.0));
  // The hold is frames 33 to 49: six errors of 1, six of -2, five of 3, whose mean is 9 / 17.
  CHECK(target.hold_mm == Approx(9.0 / 17.0));
}

TEST_CASE("Where nothing is claimed nothing is said about ellipsoids") {
  const RunScore score = score_run(bundle, recording, run_with_errors({1}));
  CHECK(std::isnan(score.targets[0].inside_95));
  CHECK(std::isnan(score.targets[0].nees));
  CHECK(std::isnan(score.targets[0].inside_95_sensor));
  CHECK(std::isnan(score.targets[0].nees_sensor));
  CHECK(std::isnan(score.innovation_rms_mm));
  CHECK(normalized_squares(bundle, run_with_errors({1})).claimed.empty());
}

TEST_CASE("Measurements are inside of the claimed ellipsoid, or of the one that the sensor widens") {
  TrialRun run = run_with_errors({1, 2, 3, 4});
  claim(run, 1.0);
  const TargetScore target = score_run(bundle, recording, run).targets[0];
  // 1, 4, 9, 16 against 7.815; with the sensor's 1 mm2 added 0.5, 2, 4.5, 8.
  CHECK(target.inside_95 == Approx(0.5));
  CHECK(target.nees == Approx(7.5));
  CHECK(target.inside_95_sensor == Approx(0.75));
  CHECK(target.nees_sensor == Approx(3.75));
}

TEST_CASE("Frames without a measurement, or without a pad on the skin, do not count") {
  TrialRun run = run_with_errors({1, 5});
  for (std::size_t i = 1; i < run.size(); i += 2) {
    if (i % 4 == 1) run[i].contact = false;
    if (i % 4 == 3) run[i].targets[0].measured.reset();
  }
  const TargetScore target = score_run(bundle, recording, run).targets[0];
  CHECK(target.frames == 30);
  CHECK(target.max_mm == Approx(1.0));

  config::Bundle padless = bundle;
  padless.scene.pads.clear();
  CHECK(is_compared(padless, run[1], 0));
  CHECK_FALSE(is_compared(padless, run[3], 0));
}

TEST_CASE("A target that was never measured has no score") {
  TrialRun run = run_with_errors({1});
  for (RunFrame& frame : run) frame.targets[0].measured.reset();
  const TargetScore target = score_run(bundle, recording, run).targets[0];
  CHECK(target.frames == 0);
  for (const double value : {target.mean_mm, target.rms_mm, target.p95_mm, target.max_mm, target.inside_95}) {
    CHECK(std::isnan(value));
  }
}

TEST_CASE("Innovations count once per marker, frames thrown away are counted, steps have percentiles") {
  TrialRun run = run_with_errors({1});
  run[0].innovation_rms = 1.0;
  run[0].markers_used = 3;
  run[1].innovation_rms = 3.0;
  run[1].markers_used = 1;
  run[2].diverged = true;
  const RunScore score = score_run(bundle, recording, run);
  CHECK(score.innovation_rms_mm == Approx(std::sqrt((3 * 1.0 + 1 * 9.0) / 4.0)));
  CHECK(score.frames == 60);
  CHECK(score.diverged == 1);
  CHECK(score.step_p50_ms == Approx(30.0));  // of 1, 2, ..., 60 ms
  CHECK(score.step_p99_ms == Approx(60.0));
}

TEST_CASE("A percentile is one of the values") {
  CHECK(percentile({3, 1, 2}, 0.5) == 2);
  CHECK(percentile({3, 1, 2}, 0.0) == 1);
  CHECK(percentile({3, 1, 2}, 1.0) == 3);
  CHECK(percentile({5}, 0.95) == 5);
  CHECK(std::isnan(percentile({}, 0.5)));
}

TEST_CASE("A mean leaves out what is not finite") {
  CHECK(finite_mean(std::vector<double>{1, NAN, 3, INFINITY}) == 2);
  CHECK(std::isnan(finite_mean(std::vector<double>{NAN})));
}
