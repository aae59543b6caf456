// Fits an explanation (a set of effects, numbers of the assumed physics, faults of the measurement) to trials:
// Levenberg-Marquardt on the posterior, with exact derivatives of the finite element body.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "core/diagnosis/likelihood.hpp"
#include "core/diagnosis/path_solver.hpp"
#include "core/diagnosis/recorder.hpp"

namespace tissued::core {

// What is supposed to be the case beside the assumed physics.
struct Hypothesis {
  std::vector<const Effect*> effects;
  bool numbers = true;  // stiffness and compressibility may differ from the assumed
  bool latency = false, registration = false;
  std::vector<SlippedMarker> slips;
  std::vector<std::pair<std::string, double>> fixed;  // numbers of effects that are not fitted, and what they are
};

struct Unknown {
  enum class Source { body, fault, discretisation };
  std::string name;  // kind.parameter, e.g. viscoelasticity.g1, latency.seconds
  std::string unit;
  Source source = Source::body;
  int fault = 0;       // of source fault: index for fault_number
  double value = 0.0;  // as FemModel knows it
  double lowest = 0.0, highest = 0.0;
  bool logarithmic = false;
  double prior = 0.0, prior_sd = 1.0;  // in the fitted scale: the logarithm where logarithmic

  double fitted() const;
  void set_fitted(double fitted);
  double slope() const { return logarithmic ? value : 1.0; }  // d value / d fitted
};

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
  FemElement element = FemElement::p2;
  const std::atomic<bool>* stop = nullptr;
};

struct Fit {
  Hypothesis hypothesis;
  std::vector<Unknown> unknowns;
  bool solved = false;               // the body had equilibria all the way
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
};

// All numbers of an effect of the fit's hypothesis, beside its parameters(): fitted, fixed, or neutral.
std::vector<double> effect_values(const Effect& effect, const Fit& fit, const Scene& scene);

// When a fit ends.
struct FitControl {
  int most_evaluations = 16;
  double worthwhile = 0.3;  // of chi square: what a further step must promise
};

// start: unknowns of these names begin at these values (a scan's, or another fit's), beside the neutral ones.
Fit fit(const FitData& data, const Hypothesis& hypothesis, const std::vector<std::pair<std::string, double>>& start,
        const FitControl& control);

// What a start promises.
struct Promise {
  std::size_t start = 0;    // index
  double chi_square = 0.0;  // after one step
  double amplitude = 0.0;   // of Effect::amplitude after that step; as it was where the effect has none
};

// Of several starts of the hypothesis' last effect, best first. Those without an equilibrium are left out.
std::vector<Promise> most_promising(const FitData& data, const Hypothesis& hypothesis,
                                    const std::vector<std::vector<std::pair<std::string, double>>>& starts);

// The unknowns at their neutral values, without a fit: what the assumed physics predicts.
Fit assess(const FitData& data, const Hypothesis& hypothesis,
           const std::vector<std::pair<std::string, double>>& values = {});

}  // namespace tissued::core
