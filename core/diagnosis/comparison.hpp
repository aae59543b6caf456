// The assumed model, the refitted and the explained one beside what was seen; and prediction of what will be.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/diagnosis/candidate.hpp"

namespace tissued::core {

// Root mean squares per axis over the seen frames; NaN where nothing was seen.
struct Misfit {
  double marker_mm = 0.0, target_mm = 0.0, force_N = 0.0;
};

// The three models that are compared: as assumed, with numbers refitted, with what was found.
struct Misfits {
  Misfit assumed, parameters, explained;
};

// One trial's course, for plots.
struct TrialCourse {
  std::string name;
  bool held_out = false;
  std::vector<double> time;                                     // (frames) s
  std::vector<double> load;                                     // (frames) mm
  std::vector<double> assumed_mm, parameters_mm, explained_mm;  // (frames) marker misfit, RMS per axis; NaN: none seen
  std::vector<double> force_seen_N, force_assumed_N, force_explained_N;  // (frames) largest pad force; empty: not seen
};

// A marker at the instant of a trial's largest load.
struct MarkerMisfit {
  std::string trial, marker;
  Vec3 rest, seen, assumed, explained;  // mm; rest in tissue coordinates, the others displacements
};

// What the three models leave of one set of trials.
struct Comparison {
  Misfits misfits;
  std::vector<TrialCourse> courses;   // (trials)
  std::vector<MarkerMisfit> markers;  // every one that was seen, of every trial
};

// (trials) (frames x channels): seen less predicted, by each of the three.
struct ModelResiduals {
  std::vector<RowMatrix> assumed, parameters, explained;
};

// (trials) (frames x channels): what a fit leaves.
std::vector<RowMatrix> residuals_of(const Fit& fit);
// (channels) mm: where markers sit beside where the scene has them, as a fit has it.
Eigen::VectorXd offset_of(const FitData& data, const Fit& fit);

// Root mean squares over frames x channels of a kind. residuals: (trials) (frames x channels); offset: (channels) where
// markers sit, taken off.
Misfit misfit_of(const std::vector<RowMatrix>& residuals, const Channels& channels, const Eigen::VectorXd& offset);

// offsets: (channels) how far markers sit from where the scene has them, as each of the three has it.
Comparison compare(const Scene& scene, const std::vector<RecordedTrial>& trials, const ModelResiduals& residuals,
                   const std::array<Eigen::VectorXd, 3>& offsets);

// (frames x channels) what a model, open loop, would have recorded in a trial; by quadratic elements. Throws ModelError
// where the body has no equilibrium on the way.
RowMatrix predict(const Scene& scene, const RecordedTrial& trial, const Candidate& model,
                  const Eigen::VectorXd& offset);

}  // namespace tissued::core
