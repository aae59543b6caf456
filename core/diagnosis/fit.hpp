// Fits an explanation (a set of effects, numbers of the assumed physics, faults of the measurement) to trials:
// Levenberg-Marquardt on the posterior, with exact derivatives of the finite element body.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "core/diagnosis/likelihood.hpp"
#include "core/diagnosis/path_solver.hpp"
#include "core/diagnosis/unknowns.hpp"

namespace tissued::core {

// What every fit of a session shares. Outlives the fits; read by several threads.
struct FitData {
  const RecordedSession* session = nullptr;
  std::vector<LoadPath> paths;  // (trials)
  ErrorModel errors;
  // What finer elements answer where nothing is left out: less the fits' own (markers and targets), (trials) (keys x
  // channels), and as a multiple of it (forces), (trials) (keys x pads).
  std::vector<RowMatrix> correction;
  std::vector<RowMatrix> force_factor;
  double correction_sd = 0.4;  // as a share of it
  std::vector<double> judged;  // (trials) share of the push that finer elements were solved for; below 0: not tried
  std::vector<RowMatrix> placement;  // (trials) placement_slopes; empty: not taken off
  FemElement element = FemElement::p2;
  const std::atomic<bool>* stop = nullptr;
  int threads = 1;  // trials at once, where nothing else runs
};

struct Fit {
  Hypothesis hypothesis;
  std::vector<Unknown> unknowns;
  bool solved = false;               // the body had equilibria all the way
  bool stopped = false;              // on the way to its end
  std::string trouble;               // why not
  double chi_square = 0.0;           // whitened residuals
  int count = 0;                     // how many
  double penalty = 0.0;              // of the priors, likewise squared
  double log_evidence = 0.0;         // Laplace; of the recordings given the hypothesis, up to a constant of the session
  double left_out_chi_square = 0.0;  // of each trial as the others predict it (one linear step from this fit)
  Eigen::MatrixXd covariance;        // (unknowns) in the fitted scale
  int evaluations = 0;
  std::vector<PathAnswer> answers;       // (trials) without derivatives
  std::vector<TrialResidual> residuals;  // (trials) with derivatives
  Eigen::VectorXd chi_square_of_channel;

  double value(const std::string& name) const;  // throws std::out_of_range
  bool has(const std::string& name) const;
  double sd(const std::string& name) const;  // of the value
  // Of a number that changes by so much with each of these values.
  double sd(const Values& slopes) const;
};

// By which evidence is too sure of itself: what a model errs is alike in many frames at many markers. Precision
// likewise.
inline constexpr double kTemperature = 6.0;

// All numbers of an effect of the fit's hypothesis, beside its parameters(): fitted, fixed, or neutral.
std::vector<double> effect_values(const Effect& effect, const Fit& fit, const Scene& scene);

// When a fit ends.
struct FitControl {
  int most_evaluations = 16;
  double worthwhile = 0.3;  // of chi square: what a further step must promise
};

// The body's numbers of a fit, those that were not fitted among them. The solver has its effects.
void set_numbers(const Hypothesis& hypothesis, const std::vector<Unknown>& unknowns, PathSolver& solver);

// start: unknowns of these names begin at these values (a scan's, or another fit's), beside the neutral ones.
Fit fit(const FitData& data, const Hypothesis& hypothesis, const Values& start, const FitControl& control);

// A step of Levenberg and Marquardt, in the fitted scale; unknowns at a bound that it would leave stay there.
Eigen::VectorXd step_of(const NormalEquations& equations, const std::vector<Unknown>& unknowns, double damping);

// The unknowns at their neutral values or at these, without a fit: what the assumed physics predicts.
Fit assess(const FitData& data, const Hypothesis& hypothesis, const Values& values = {});
// Likewise what all else is judged by: out of time or not.
Fit assess_unhurried(FitData data, const Hypothesis& hypothesis, const Values& values = {});

}  // namespace tissued::core
