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

constexpr int kProbes = 7;  // of a marker
constexpr double kSlopeError = 0.15;

// Every marker seven times: moved along each axis, there and back, and where it is.
Scene with_moved_markers(const Scene& scene) {
  Scene moved = scene;
  moved.targets.clear();
  moved.markers.clear();
  for (const Marker& marker : scene.markers) {
    for (int axis = 0; axis < 3; ++axis)
      for (double step : {kStep, -kStep}) {
        Marker other = marker;
        other.rest[axis] += step;
        moved.markers.push_back(std::move(other));
      }
    moved.markers.push_back(marker);
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

Placement placement_of(const Scene& scene, std::span<const LoadPath> paths, double offset) {
  const auto markers = static_cast<Eigen::Index>(scene.markers.size());
  Placement placement;
  for (const LoadPath& path : paths)
    placement.slopes.push_back(RowMatrix::Zero(static_cast<Eigen::Index>(path.keys().size()), 9 * markers));
  placement.doubt = RowMatrix::Zero(static_cast<Eigen::Index>(paths.size()), 3 * markers);
  try {
    PathSolver solver(with_moved_markers(scene), {});
    for (std::size_t k = 0; k < paths.size(); ++k) {
      PathAnswer answer;
      if (!solver.solve(paths[k], 0, {}, answer)) continue;
      const auto trial = static_cast<Eigen::Index>(k);
      const auto peak = static_cast<Eigen::Index>(paths[k].key_at_peak());
      for (Eigen::Index m = 0; m < markers; ++m) {
        const auto probe = [&](int i) { return answer.values.middleCols<3>(3 * (kProbes * m + i)); };
        for (int axis = 0; axis < 3; ++axis) {
          auto slope = placement.slopes[k].middleCols<3>(9 * m + 3 * axis);
          slope = (probe(2 * axis) - probe(2 * axis + 1)) / (2.0 * kStep);
          // Half the curvature times the offset's square, whose mean is its variance and whose variance twice its
          // square.
          const Eigen::RowVector3d bend = (probe(2 * axis) + probe(2 * axis + 1) - 2.0 * probe(6)).row(peak) /
                                          (2.0 * kStep * kStep) * offset * offset;
          placement.doubt.row(trial).segment<3>(3 * m) +=
              (3.0 * bend.array().square() + (kSlopeError * offset * slope.row(peak)).array().square()).matrix();
        }
      }
    }
  } catch (const ModelError&) {
    // A marker that is all but too far off: nothing is taken off then.
  }
  placement.doubt = placement.doubt.cwiseSqrt();
  return placement;
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
