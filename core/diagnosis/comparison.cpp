#include "core/diagnosis/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/diagnosis/seen_motion.hpp"

namespace tissued::core {

namespace {

constexpr double kTravel = 2.0;  // mm between the keys of a path

LoadPath path_of(const RecordedTrial& trial, const Scene& scene) {
  return trial.motion ? LoadPath(trial, scene, MotionSteps{kFineStep * period_of(trial), 1e9, false})
                      : LoadPath(trial, scene, kTravel);
}

std::vector<double> of_frames(const RowMatrix& residual, const Channels& channels, const Eigen::VectorXd& offset) {
  std::vector<double> out;
  for (Eigen::Index f = 0; f < residual.rows(); ++f)
    out.push_back(misfit_of({residual.row(f)}, channels, offset).marker_mm);
  return out;
}

// The largest of the pads' forces in every frame, and how far two of the models are from it.
void add_forces(const RecordedTrial& trial, const Channels& channels, const RowMatrix& off_assumed,
                const RowMatrix& off_explained, TrialCourse& course) {
  bool has_force = false;
  for (Eigen::Index f = 0; f < trial.seen.rows(); ++f) {
    double seen = 0.0, assumed = 0.0, explained = 0.0;
    for (int pad = 0; pad < channels.pads; ++pad) {
      const auto at = channels.of_force(pad);
      const Eigen::RowVector3d force = trial.seen.row(f).segment<3>(at);
      if (!force.allFinite()) continue;
      has_force = true;
      if (force.norm() < seen) continue;
      seen = force.norm();
      assumed = (force - off_assumed.row(f).segment<3>(at)).norm();
      explained = (force - off_explained.row(f).segment<3>(at)).norm();
    }
    course.force_seen_N.push_back(seen);
    course.force_assumed_N.push_back(assumed);
    course.force_explained_N.push_back(explained);
  }
  if (has_force) return;
  course.force_seen_N.clear();
  course.force_assumed_N.clear();
  course.force_explained_N.clear();
}

// At the frame of the trial's largest load.
void add_markers(const Scene& scene, const RecordedTrial& trial, Eigen::Index peak, const RowMatrix& off_assumed,
                 const RowMatrix& off_explained, const Eigen::VectorXd& offset, std::vector<MarkerMisfit>& out) {
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    const auto first = static_cast<Eigen::Index>(3 * i);
    const auto at = [&](const RowMatrix& from) -> Vec3 {
      return from.row(peak).segment<3>(first).transpose() - offset.segment<3>(first);
    };
    const Vec3 seen = at(trial.seen);
    if (!seen.allFinite()) continue;
    out.push_back({trial.name, scene.markers[i].name, scene.markers[i].rest, seen, seen - at(off_assumed),
                   seen - at(off_explained)});
  }
}

}  // namespace

std::vector<RowMatrix> residuals_of(const Fit& fit) {
  std::vector<RowMatrix> out;
  for (const TrialResidual& trial : fit.residuals) out.push_back(trial.residual);
  return out;
}

Eigen::VectorXd offset_of(const FitData& data, const Fit& fit) {
  return nuisances(data.errors, pointers_to(fit.residuals)).offset;
}

Misfit misfit_of(const std::vector<RowMatrix>& residuals, const Channels& channels, const Eigen::VectorXd& offset) {
  std::array<double, 3> square{}, count{};
  for (const RowMatrix& residual : residuals)
    for (Eigen::Index f = 0; f < residual.rows(); ++f)
      for (int c = 0; c < channels.count(); ++c) {
        if (!std::isfinite(residual(f, c))) continue;
        const int kind = channels.is_marker(c) ? 0 : channels.is_force(c) ? 2 : 1;
        square[kind] += std::pow(residual(f, c) - offset[c], 2);
        count[kind] += 1.0;
      }
  const auto rms = [&](int kind) {
    return count[kind] > 0.0 ? std::sqrt(square[kind] / count[kind]) : std::numeric_limits<double>::quiet_NaN();
  };
  return {rms(0), rms(1), rms(2)};
}

Comparison compare(const Scene& scene, const std::vector<RecordedTrial>& trials, const ModelResiduals& residuals,
                   const std::array<Eigen::VectorXd, 3>& offsets) {
  const Channels channels = channels_of(scene);
  Comparison out;
  out.misfits = {misfit_of(residuals.assumed, channels, offsets[0]),
                 misfit_of(residuals.parameters, channels, offsets[1]),
                 misfit_of(residuals.explained, channels, offsets[2])};
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const LoadPath path = path_of(trials[k], scene);
    TrialCourse course;
    course.name = trials[k].name;
    course.time = trials[k].time;
    for (double time : course.time) course.load.push_back(path.load(time));
    course.assumed_mm = of_frames(residuals.assumed[k], channels, offsets[0]);
    course.parameters_mm = of_frames(residuals.parameters[k], channels, offsets[1]);
    course.explained_mm = of_frames(residuals.explained[k], channels, offsets[2]);
    add_forces(trials[k], channels, residuals.assumed[k], residuals.explained[k], course);
    const auto peak = std::max_element(course.load.begin(), course.load.end()) - course.load.begin();
    add_markers(scene, trials[k], peak, residuals.assumed[k], residuals.explained[k], offsets[2], out.markers);
    out.courses.push_back(std::move(course));
  }
  return out;
}

RowMatrix predict(const Scene& scene, const RecordedTrial& trial, const Candidate& model,
                  const Eigen::VectorXd& offset) {
  PathSolver solver(scene, model.hypothesis.effects);
  set_numbers(model.hypothesis, model.best().unknowns, solver);
  const MeasurementFaults faults = faults_of(model.hypothesis, model.best().unknowns);
  const LoadPath path = path_of(trial, scene);
  PathAnswer answer;
  if (!solver.solve(path, 0, {}, answer)) throw ModelError(trial.name + ": " + solver.trouble());
  // Markers that slipped did so before a trial that is predicted.
  constexpr int kAfterAll = std::numeric_limits<int>::max();
  RowMatrix out = recorded(trial, kAfterAll, path, scene, answer.values, faults);
  out.rowwise() += offset.transpose();
  return out;
}

}  // namespace tissued::core
