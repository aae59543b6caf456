// What an explanation leaves open: the numbers that a fit finds, their bounds and their priors.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "core/diagnosis/recorder.hpp"
#include "core/effects/effect.hpp"

namespace tissued::core {

// Names and values of some unknowns.
using Values = std::vector<std::pair<std::string, double>>;

// What is supposed to be the case beside the assumed physics.
struct Hypothesis {
  std::vector<const Effect*> effects;
  bool numbers = true;  // stiffness and compressibility may differ from the assumed
  bool latency = false, registration = false;
  int releases = 0;  // of so many trials, from the first on, it is open when exactly the body was let go
  std::vector<SlippedMarker> slips;
  Values fixed;  // numbers of effects that are not fitted, and what they are
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

// Every unknown of a hypothesis at its neutral value; the last is the share of discretisation, of this prior sd.
std::vector<Unknown> unknowns_of(const Hypothesis& hypothesis, const Scene& scene, double discretisation_sd);

// The faults of the measurement that are among them.
MeasurementFaults faults_of(const Hypothesis& hypothesis, const std::vector<Unknown>& unknowns);

// Sets those that are named, within their bounds.
void begin_at(const Values& start, std::vector<Unknown>& unknowns);

// The priors, Gaussian in the fitted scale: their squared distance, what they add to the normal matrix, and to the
// gradient.
double penalty_of(const std::vector<Unknown>& unknowns);
Eigen::MatrixXd with_prior(const Eigen::MatrixXd& normal, const std::vector<Unknown>& unknowns);
Eigen::VectorXd pull_of_prior(const std::vector<Unknown>& unknowns);

}  // namespace tissued::core
