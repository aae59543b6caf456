// A whole evaluation of a small bundle: the same for any number of threads, CSV that adds up.
#include "daemon/evaluation.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "daemon/ctl_options.hpp"
#include "daemon/evaluation_csv.hpp"
#include "daemon/evaluation_figures.hpp"
#include "daemon/evaluation_page.hpp"
#include "daemon/evaluation_summary.hpp"
#include "tests/daemon/evaluation_bundle.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

EvaluationRequest request_for(const std::filesystem::path& bundle) {
  EvaluationRequest request;
  request.bundles = {bundle.string()};
  request.models = {named_model("admm"), named_model("kf-admm"), named_model("paper")};
  return request;
}

std::unique_ptr<Evaluation> evaluate(const EvaluationRequest& request, int threads = 2) {
  auto evaluation = std::make_unique<Evaluation>(request);
  evaluation->run(threads, [](std::size_t) {});
  return evaluation;
}

using Rows = std::vector<std::map<std::string, std::string>>;

// No cell of these tests is quoted.
Rows read_csv(const std::string& text) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line) {
      if (c == ',') {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    return cells;
  };
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const auto names = split(line);
  Rows rows;
  while (std::getline(lines, line)) {
    const auto cells = split(line);
    REQUIRE(cells.size() == names.size());
    rows.emplace_back();
    for (std::size_t i = 0; i < names.size(); ++i) rows.back()[names[i]] = cells[i];
  }
  return rows;
}

std::string runs_csv(const Evaluation& evaluation) {
  std::ostringstream out;
  write_runs_csv(evaluation, out);
  return out.str();
}

std::string frames_csv(const Evaluation& evaluation) {
  std::ostringstream out;
  write_frames_csv(evaluation, out);
  return out.str();
}

Rows without_times(Rows rows) {
  for (auto& row : rows) {
    row.erase("step_p50_ms");
    row.erase("step_p99_ms");
  }
  return rows;
}

}  // namespace

TEST_CASE("An evaluation is the same for any number of threads") {
  const TemporaryFolder folder;
  const EvaluationRequest request = request_for(write_evaluation_bundle(folder));
  const auto once = evaluate(request, 1);
  for (const int threads : {1, 2, 5}) {
    const auto again = evaluate(request, threads);
    CHECK(without_times(read_csv(runs_csv(*again))) == without_times(read_csv(runs_csv(*once))));
    CHECK(frames_csv(*again) == frames_csv(*once));
  }
}

TEST_CASE("Every trial meets every model with every marker set, in open loop once") {
  const TemporaryFolder folder;
  const auto evaluation = evaluate(request_for(write_evaluation_bundle(folder)));
  std::vector<std::string> runs;
  for (const auto& row : read_csv(runs_csv(*evaluation))) {
    runs.push_back(row.at("trial") + ' ' + row.at("model") + ' ' + row.at("marker_set"));
    CHECK(row.at("bundle") == "cube");
    CHECK(row.at("target") == "T1");
    CHECK(row.at("frames") == "70");
    CHECK(row.at("compared_frames") == "69");
  }
  CHECK(runs == std::vector<std::string>{"shallow admm -", "shallow kf-admm most", "shallow kf-admm few",
                                         "shallow paper most", "shallow paper few", "deep admm -", "deep kf-admm most",
                                         "deep kf-admm few", "deep paper most", "deep paper few"});
  CHECK(evaluation->run_count() == 10);
}

TEST_CASE("A session keeps from trial to trial what a trial from rest has not") {
  const TemporaryFolder folder;
  EvaluationRequest request = request_for(write_evaluation_bundle(folder));
  const auto apart = evaluate(request);
  request.session = true;
  const auto session = evaluate(request);
  CHECK(session->run_count() == 5);  // as many as there are models with marker sets
  const Rows from_rest = read_csv(frames_csv(*apart)), in_turn = read_csv(frames_csv(*session));
  REQUIRE(in_turn.size() == from_rest.size());
  std::set<std::string> changed;
  for (std::size_t i = 0; i < in_turn.size(); ++i) {
    REQUIRE(in_turn[i].at("trial") == from_rest[i].at("trial"));
    if (without_times({in_turn[i]}) == without_times({from_rest[i]})) continue;
    changed.insert(in_turn[i].at("trial") + ' ' + in_turn[i].at("model"));
  }
  // In open loop the trials differ too: the body still swings a little, and its offsets at rest are known better.
  CHECK(changed.count("deep kf-admm") == 1);
  CHECK(changed.count("shallow kf-admm") == 0);
  CHECK(changed.count("shallow admm") == 0);
  CHECK(frames_csv(*evaluate(request, 1)) == frames_csv(*session));
}

TEST_CASE("The scores of a run are those of its frames") {
  const TemporaryFolder folder;
  const auto evaluation = evaluate(request_for(write_evaluation_bundle(folder)));
  const Rows frames = read_csv(frames_csv(*evaluation));
  CHECK(frames.size() == 10 * kCubeFrames);
  for (const auto& run : read_csv(runs_csv(*evaluation))) {
    INFO(run.at("trial") << ' ' << run.at("model") << ' ' << run.at("marker_set"));
    std::vector<double> errors;
    double squares = 0.0, nees = 0.0;
    int inside = 0;
    for (const auto& frame : frames) {
      const auto same = [&](const char* key) { return frame.at(key) == run.at(key); };
      if (!same("trial") || !same("model") || !same("marker_set") || frame.at("error_mm").empty()) continue;
      errors.push_back(std::stod(frame.at("error_mm")));
      for (const char* axis : {"error_x_mm", "error_y_mm", "error_z_mm"}) {
        squares += std::pow(std::stod(frame.at(axis)), 2);
      }
      if (frame.at("nees").empty()) continue;
      nees += std::stod(frame.at("nees"));
      inside += std::stod(frame.at("nees")) <= 7.815 ? 1 : 0;
    }
    REQUIRE(errors.size() == 69);
    std::ranges::sort(errors);
    double sum = 0.0;
    for (const double error : errors) sum += error;
    const auto is = [&run](const char* key, double value) {
      CHECK(std::stod(run.at(key)) == Approx(value).epsilon(1e-4));
    };
    is("mean_mm", sum / 69);
    is("rms_mm", std::sqrt(squares / 69));
    is("p95_mm", errors[65]);  // the 66th of 69 is the first that 95 % do not exceed
    is("max_mm", errors[68]);
    if (run.at("marker_set") == "-") {
      for (const char* key : {"inside_95", "nees", "inside_95_sensor", "nees_sensor", "innovation_rms_mm"}) {
        CHECK(run.at(key).empty());
      }
    } else {
      is("nees", nees / 69);
      is("inside_95", inside / 69.0);
      CHECK(std::stod(run.at("innovation_rms_mm")) > 0.0);
    }
  }
}

TEST_CASE("A variant is a model with keys of its own, after those of all models") {
  const TemporaryFolder folder;
  EvaluationRequest request = request_for(write_evaluation_bundle(folder));
  request.models = {named_model("admm"), parse_variant("longer:simulator.kind=admm,simulator.iterations=7")};
  request.overrides = {"simulator.iterations=3"};
  request.trials = {"deep"};
  const auto evaluation = evaluate(request);
  const BundleEvaluation& bundle = *evaluation->bundles().front();
  REQUIRE(bundle.setups.size() == 2);
  CHECK(bundle.setups[0].config.simulator.solver.iterations == 3);
  CHECK(bundle.setups[1].config.simulator.solver.iterations == 7);
  CHECK(bundle.recordings.size() == 1);
  for (const Setup& setup : bundle.setups) CHECK(setup.config.simulator.solver.threads == 1);
}

TEST_CASE("Of every choice of pads the deepest push is followed from its jump on") {
  const TemporaryFolder folder;
  const auto evaluation = evaluate(request_for(write_evaluation_bundle(folder)));
  const BundleEvaluation& bundle = *evaluation->bundles().front();
  REQUIRE(bundle.jump_trials == std::vector<std::size_t>{1});
  for (const auto& runs : bundle.runs) {
    CHECK(runs[0].jump.empty());
    CHECK(runs[1].jump_begin == 5);
    CHECK(runs[1].jump.size() == 5 + 60);  // 600 iterations, ten a frame
  }
  // A cube of six elements is settled soon, and not before the pad arrives.
  for (const std::size_t setup : all_setups(bundle)) {
    CHECK(iterations_to_settle(bundle, setup) >= 10);
    CHECK(iterations_to_settle(bundle, setup) <= 600);
  }
}

TEST_CASE("Means over all runs weigh every frame alike") {
  const TemporaryFolder folder;
  const auto evaluation = evaluate(request_for(write_evaluation_bundle(folder)));
  const BundleEvaluation& bundle = *evaluation->bundles().front();
  const SetupSummary summary = summarize(bundle, 1);
  const TargetScore& shallow = bundle.runs[1][0].score.targets[0];
  const TargetScore& deep = bundle.runs[1][1].score.targets[0];
  CHECK(summary.hold_mm == Approx((shallow.hold_mm + deep.hold_mm) / 2));
  CHECK(summary.rms_mm == Approx(std::sqrt((std::pow(shallow.rms_mm, 2) + std::pow(deep.rms_mm, 2)) / 2)));
  CHECK(summary.max_mm == std::max(shallow.max_mm, deep.max_mm));
  CHECK(summary.nees == Approx((shallow.nees + deep.nees) / 2));
  CHECK(summary.frames == 140);
}

TEST_CASE("Setups are told apart and picked for the figures") {
  const TemporaryFolder folder;
  EvaluationRequest request = request_for(write_evaluation_bundle(folder));
  request.marker_sets = {"few", "all"};
  const Evaluation evaluation(request);
  const BundleEvaluation& bundle = *evaluation.bundles().front();
  CHECK(all_setups(bundle) == SetupList{0, 1, 2, 3, 4});
  CHECK(closed_loop_setups(bundle) == SetupList{1, 2, 3, 4});
  CHECK(best_seen_setups(bundle) == SetupList{0, 2, 4});  // `all` has more markers
  CHECK(setup_name(bundle.setups[0]) == "admm");
  CHECK(setup_name(bundle.setups[1]) == "kf-admm, few");
  CHECK(setup_style(bundle, 2).colour == setup_style(bundle, 1).colour);
  CHECK(setup_style(bundle, 2).dash != setup_style(bundle, 1).dash);
  CHECK(setup_style(bundle, 3).colour != setup_style(bundle, 1).colour);
}

TEST_CASE("Chi square with three degrees of freedom is that of the tables") {
  CHECK(chi_square_3(0.0) == 0.0);
  CHECK(chi_square_3(0.352) == Approx(0.05).margin(2e-4));
  CHECK(chi_square_3(2.366) == Approx(0.50).margin(2e-4));
  CHECK(chi_square_3(7.815) == Approx(0.95).margin(2e-5));
  CHECK(chi_square_3(16.266) == Approx(0.999).margin(2e-6));
}

TEST_CASE("What is not there is named before anything runs") {
  const TemporaryFolder folder;
  const EvaluationRequest good = request_for(write_evaluation_bundle(folder));
  EvaluationRequest bad = good;
  bad.marker_sets = {"most", "mars"};
  CHECK_THROWS_WITH(Evaluation(bad), Catch::Contains("--marker-sets") && Catch::Contains("`mars`") &&
                                         Catch::Contains("all, most or few"));
  bad = good;
  bad.trials = {"deep", "deeper"};
  CHECK_THROWS_WITH(Evaluation(bad), Catch::Contains("`deeper`") && Catch::Contains("shallow or deep"));
  bad = good;
  bad.bundles = {"/no/such/bundle"};
  CHECK_THROWS_AS(Evaluation(bad), config::ConfigError);
  bad = good;
  bad.overrides = {"simulator.iterations=0"};
  CHECK_THROWS_WITH(Evaluation(bad), Catch::Contains("/simulator/iterations"));
  std::filesystem::remove(folder.path() / "deep.csv");
  CHECK_THROWS_WITH(Evaluation(good), Catch::Contains("deep.csv"));
}

TEST_CASE("A bundle without measured targets leaves their columns empty and says so") {
  const TemporaryFolder folder;
  const auto path = write_evaluation_bundle(folder);
  protocol::Trial blind = cube_trial(5.0, 2);
  for (std::size_t frame = 0; frame < kCubeFrames; ++frame) {
    blind.seen[frame * 6 + 4] = 0;
    blind.positions[frame * 6 + 4].fill(std::nan(""));
  }
  protocol::write_nexus_csv(blind, path / "deep.csv");
  EvaluationRequest request = request_for(path);
  request.trials = {"deep"};
  const auto evaluation = evaluate(request);
  CHECK_FALSE(evaluation->bundles().front()->has_measured_target());
  for (const auto& row : read_csv(runs_csv(*evaluation))) {
    for (const char* key : {"hold_mm", "mean_mm", "rms_mm", "p95_mm", "max_mm", "inside_95", "nees"}) {
      CHECK(row.at(key).empty());
    }
    CHECK(row.at("compared_frames") == "0");
  }
  CHECK_THAT(evaluation_page(*evaluation, 1), Catch::Contains("No target was measured"));
}
