#include "core/diagnosis/placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/diagnosis/path_solver.hpp"

namespace tissued::core {

namespace {

constexpr double kStep = 0.5;      // mm, to both sides: about what is to be judged
constexpr double kFarthest = 1.5;  // mm along an axis; what is further off is not how a marker was placed
constexpr int kPasses = 2;         // the offset is better known once its effect is taken off

// Every marker six times: moved along each axis, there and back.
Scene with_moved_markers(const Scene& scene) {
  Scene moved = scene;
  moved.targets.clear();
  moved.markers.clear();
  for (const Marker& marker : scene.markers)
    for (int axis = 0; axis < 3; ++axis)
      for (double step : {kStep, -kStep}) {
        Marker other = marker;
        other.rest[axis] += step;
        moved.markers.push_back(std::move(other));
      }
  return moved;
}

// (keys x 3 markers) for an offset of every marker, of at most so many mm along an axis.
RowMatrix moved_by(const RowMatrix& slopes, const Eigen::VectorXd& offset, double farthest) {
  const Eigen::Index markers = slopes.cols() / 9;
  RowMatrix out = RowMatrix::Zero(slopes.rows(), 3 * markers);
  for (Eigen::Index m = 0; m < markers; ++m)
    for (Eigen::Index j = 0; j < 3; ++j)
      out.middleCols<3>(3 * m) +=
          std::clamp(offset[3 * m + j], -farthest, farthest) * slopes.middleCols<3>(9 * m + 3 * j);
  return out;
}

}  // namespace

std::vector<RowMatrix> placement_slopes(const Scene& scene, std::span<const LoadPath> paths) {
  const auto markers = static_cast<Eigen::Index>(scene.markers.size());
  std::vector<RowMatrix> slopes;
  for (const LoadPath& path : paths)
    slopes.push_back(RowMatrix::Zero(static_cast<Eigen::Index>(path.keys().size()), 9 * markers));
  try {
    PathSolver solver(with_moved_markers(scene), {});
    for (std::size_t k = 0; k < paths.size(); ++k) {
      PathAnswer answer;
      if (!solver.solve(paths[k], 0, {}, answer)) continue;
      for (Eigen::Index probe = 0; probe < 3 * markers; ++probe)
        slopes[k].middleCols<3>(3 * probe) =
            (answer.values.middleCols<3>(6 * probe) - answer.values.middleCols<3>(6 * probe + 3)) / (2.0 * kStep);
    }
  } catch (const ModelError&) {
    // A marker that is all but too far off: nothing is taken off then.
  }
  return slopes;
}

namespace {

void take_off(const ErrorModel& errors, const Channels& channels, std::span<const LoadPath> paths,
              std::span<const RowMatrix> slopes, const std::vector<RecordedTrial>& trials, double farthest,
              std::vector<TrialResidual>& residuals) {
  std::vector<RowMatrix> before;
  for (const TrialResidual& trial : residuals) before.push_back(trial.residual.leftCols(3 * channels.markers));
  for (int pass = 0; pass < kPasses; ++pass) {
    const Eigen::VectorXd offset = nuisances(errors, pointers_to(residuals)).offset;
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      const RowMatrix moved = moved_by(slopes[k], offset, farthest);
      for (Eigen::Index f = 0; f < residuals[k].residual.rows(); ++f) {
        auto row = residuals[k].residual.row(f).head(3 * channels.markers);
        row = before[k].row(f);
        const PathPlace place = paths[k].place(trials[k].time[static_cast<std::size_t>(f)]);
        for (std::size_t p = 0; p < place.keys.size(); ++p) row -= place.weights[p] * moved.row(place.keys[p]);
      }
    }
  }
}

}  // namespace

void take_off_placement(const ErrorModel& errors, const Channels& channels, std::span<const LoadPath> paths,
                        std::span<const RowMatrix> slopes, const std::vector<RecordedTrial>& trials,
                        std::vector<TrialResidual>& residuals) {
  take_off(errors, channels, paths, slopes, trials, kFarthest, residuals);
}

void take_off_placement(const ErrorModel& errors, const Channels& channels, std::span<const LoadPath> paths,
                        std::span<const RowMatrix> slopes, const std::vector<RecordedTrial>& trials,
                        std::vector<TrialResidual>& residuals, std::size_t parameter) {
  // What is linear in the residuals is linear in their derivatives, where as much was seen.
  std::vector<TrialResidual> columns;
  for (const TrialResidual& trial : residuals) {
    columns.push_back({trial.trial, trial.derivatives[parameter], {}, trial.load});
    columns.back().residual = trial.residual.array().isFinite().select(columns.back().residual, NAN);
  }
  take_off(errors, channels, paths, slopes, trials, std::numeric_limits<double>::infinity(), columns);
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    RowMatrix& derivative = residuals[k].derivatives[parameter];
    derivative = columns[k].residual.array().isFinite().select(columns[k].residual, derivative);
  }
}

}  // namespace tissued::core
