#include "daemon/calibration.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "config/daemon_config.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/evaluation.hpp"
#include "daemon/shared_calibration.hpp"
#include "tests/daemon/evaluation_bundle.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

CalibrationRequest request_for(const std::filesystem::path& bundle) {
  CalibrationRequest request;
  request.bundle = bundle.string();
  request.model = "pbd";
  request.keys = {{"simulator.pbd.cluster_spacing", 6.0, 20.0}, {"simulator.pbd.cluster_radius", 3.0, 12.0}};
  return request;
}

std::string refusal(const CalibrationRequest& request) {
  try {
    const Calibration calibration(request);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing was refused";
}

// What `evaluate` says: the sum of hold_mm.
double evaluated_sum(const CalibrationRequest& request, const SearchPoint& point) {
  EvaluationRequest evaluate;
  evaluate.bundles = {request.bundle};
  evaluate.trials = request.trials;
  evaluate.models = {parse_variant("v:simulator.kind=pbd,simulator.pbd.cluster_spacing=" + std::to_string(point[0]) +
                                   ",simulator.pbd.cluster_radius=" + std::to_string(point[1]))};
  Evaluation evaluation(evaluate);
  evaluation.run(1, [](std::size_t) {});
  double sum = 0.0;
  for (const EvaluatedRun& run : evaluation.bundles().front()->runs.front())
    for (const TargetScore& target : run.score.targets) sum += target.hold_mm;
  return sum;
}

}  // namespace

TEST_CASE("A calibration's objective is the sum of what evaluate finds in the holds, on any number of threads") {
  const TemporaryFolder folder;
  CalibrationRequest request = request_for(write_evaluation_bundle(folder));
  const std::vector<SearchPoint> points{{11.0, 8.5}, {9.0, 10.0}, {20.0, 3.0}};
  const Calibration calibration(request);
  CHECK(calibration.distances() == 2);
  const MpiRanks ranks;
  const std::vector<double> values = SharedCalibration(ranks, calibration, 1)(points);
  CHECK(values[0] == Approx(evaluated_sum(request, points[0])).epsilon(1e-12));
  CHECK(values[1] == Approx(evaluated_sum(request, points[1])).epsilon(1e-12));
  CHECK(values[0] != values[1]);
  // The radius is below half of the spacing.
  CHECK(values[2] == Calibration::kRefused);
  CHECK(SharedCalibration(ranks, calibration, 3)(points) == values);
  request.trials = {"deep"};
  const Calibration deep(request);
  CHECK(deep.distances() == 1);
  CHECK(deep.trials() == 1);
  CHECK(deep.part(points[0], 0) == Approx(evaluated_sum(request, points[0])).epsilon(1e-12));
}

TEST_CASE("What cannot be calibrated is named") {
  const TemporaryFolder folder;
  const CalibrationRequest good = request_for(write_evaluation_bundle(folder));
  CHECK(refusal(good) == "nothing was refused");
  // The ranges of Tagliabue et al.: not every point of them is a model, but some are.
  CalibrationRequest wide = good;
  wide.keys = {{"simulator.pbd.cluster_spacing", 5.0, 35.0},
               {"simulator.pbd.cluster_radius", 2.5, 15.0},
               {"simulator.pbd.cluster_stiffness", 0.0, 1.0}};
  CHECK(refusal(wide) == "nothing was refused");
  CalibrationRequest bad = good;
  bad.keys[0].key = "simulator.pbd.cluster_spacin";
  CHECK_THAT(refusal(bad), Catch::Contains("cluster_spacin") && Catch::Contains("unknown key"));
  bad = good;
  bad.keys[1] = {"simulator.pbd.cluster_stiffness", 0.2, 1.5};
  CHECK_THAT(refusal(bad), Catch::Contains("1.5 is above the maximum 1"));
  bad = good;
  bad.keys = {{"simulator.pbd.iterations", 5.0, 15.0}};
  CHECK_THAT(refusal(bad), Catch::Contains("is not an integer"));
  bad = good;
  bad.targets = {"T9"};
  CHECK_THAT(refusal(bad), Catch::Contains("--target") && Catch::Contains("T9") && Catch::Contains("T1"));
  bad = good;
  bad.trials = {"steep"};
  CHECK_THAT(refusal(bad), Catch::Contains("--trials") && Catch::Contains("steep") && Catch::Contains("shallow"));
}

TEST_CASE("The configuration that a calibration writes loads, with the numbers of its point") {
  const TemporaryFolder folder;
  CalibrationRequest request = request_for(write_evaluation_bundle(folder));
  request.overrides = {"simulator.pbd.readout=nearest", "gravity=[0,0,-0.5]"};
  const Calibration calibration(request);
  const auto file = folder.write("found.json", calibration.config_at({1.0 / 0.15, 7.25}).dump());
  const config::DaemonConfig config = config::load_daemon_config(file);
  CHECK(config.simulator.kind == "pbd");
  CHECK(config.simulator.pbd.cluster_spacing == 1.0 / 0.15);
  CHECK(config.simulator.pbd.cluster_radius == 7.25);
  CHECK(config.simulator.pbd.readout == core::PbdReadout::nearest);
  CHECK(config.bundle.scene.gravity.z() == -0.5);
}
