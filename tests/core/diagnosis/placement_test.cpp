#include "core/diagnosis/placement.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/diagnosis/path_solver.hpp"
#include "core/diagnosis/recorder.hpp"
#include "tests/core/diagnosis/twin_session.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

// Markers ride up to half a millimetre along each axis from where the scene has them; solved with both scenes.
TEST_CASE("what a marker's place does to its motion is taken off, what it does at rest is kept", "[diagnosis]") {
  const Scene stated = box_scene({5, 4, 3, 10.0}, 12);
  Scene real = stated;
  std::mt19937 generator(5);
  for (Marker& marker : real.markers) marker.rest += 0.5 * random_vector(generator);
  const Channels channels = channels_of(stated);
  const int seen = 3 * channels.markers;
  const std::vector<RecordedTrial> trials{push_trial(stated, "one", {0}, 6.0, 8.0),
                                          push_trial(stated, "other", {1}, 5.0, 8.0)};
  std::vector<LoadPath> paths;
  for (const RecordedTrial& trial : trials) paths.emplace_back(trial, stated, 3.0);
  PathSolver by_stated(stated, {}), by_real(real, {});
  std::vector<TrialResidual> residuals;
  Eigen::RowVectorXd offset = Eigen::RowVectorXd::Zero(channels.count());
  for (int m = 0; m < channels.markers; ++m)
    offset.segment<3>(channels.of_marker(m)) = (real.markers[m].rest - stated.markers[m].rest).transpose();
  for (std::size_t k = 0; k < trials.size(); ++k) {
    PathAnswer a, b;
    REQUIRE(by_stated.solve(paths[k], static_cast<int>(k), {}, a));
    REQUIRE(by_real.solve(paths[k], static_cast<int>(k), {}, b));
    TrialResidual residual;
    residual.trial = static_cast<int>(k);
    residual.residual =
        recorded(trials[k], 0, paths[k], real, b.values, {}) - recorded(trials[k], 0, paths[k], stated, a.values, {});
    residual.residual.rowwise() += offset;
    residual.load.resize(trials[k].frame_count());
    for (int f = 0; f < trials[k].frame_count(); ++f)
      residual.load[f] = paths[k].load(trials[k].time[f]) / paths[k].peak_load();
    residuals.push_back(std::move(residual));
  }
  const auto moved = [&] {
    double square = 0.0;
    for (const TrialResidual& trial : residuals)
      square += (trial.residual.leftCols(seen).rowwise() - offset.head(seen)).squaredNorm();
    return std::sqrt(square);
  };
  ErrorModel errors;
  errors.noise = Eigen::VectorXd::Constant(channels.count(), 0.05);
  errors.offset = Eigen::VectorXd::Constant(channels.count(), 0.5);
  errors.discretisation = RowMatrix::Constant(2, channels.count(), 0.03);
  const double before = moved();
  REQUIRE(before > 1.0);
  const Placement placement = placement_of(stated, paths, 0.5);
  take_off_placement(errors, channels, paths, placement.slopes, trials, residuals);
  CHECK(moved() < 0.25 * before);
  // What is left at the peaks is within what is said.
  double left = 0.0, said = 0.0;
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const auto peak = std::max_element(residuals[k].load.begin(), residuals[k].load.end()) - residuals[k].load.begin();
    left += (residuals[k].residual.row(peak).head(seen) - offset.head(seen)).squaredNorm();
    said += placement.doubt.row(static_cast<Eigen::Index>(k)).squaredNorm();
  }
  CHECK(left < said);
}
