#include "core/diagnosis/unknowns.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

namespace {

Unknown body_unknown(std::string name, std::string unit, double value, double lowest, double highest, bool logarithmic,
                     double prior_sd) {
  Unknown unknown{std::move(name), std::move(unit), Unknown::Source::body, 0,   value,
                  lowest,          highest,         logarithmic,           0.0, prior_sd};
  unknown.prior = unknown.fitted();
  return unknown;
}

Unknown fault_unknown(std::string name, std::string unit, int fault, double limit, double prior_sd) {
  return {std::move(name), std::move(unit), Unknown::Source::fault, fault, 0.0, -limit, limit, false, 0.0, prior_sd};
}

// Half the body's longest side.
double reach_of(const Scene& scene) {
  return 0.5 * (scene.mesh.rest.colwise().maxCoeff() - scene.mesh.rest.colwise().minCoeff()).maxCoeff();
}

bool is_place(const std::string& parameter) {
  return parameter.starts_with("center.") || parameter.starts_with("at.") || parameter.starts_with("axis.");
}

}  // namespace

double Unknown::fitted() const { return logarithmic ? std::log(value) : value; }

void Unknown::set_fitted(double fitted) {
  value = std::clamp(logarithmic ? std::exp(fitted) : fitted, lowest, highest);
}

std::vector<Unknown> unknowns_of(const Hypothesis& hypothesis, const Scene& scene, double discretisation_sd) {
  constexpr double kDegree = 3.14159265358979 / 180.0;
  std::vector<Unknown> unknowns;
  if (hypothesis.numbers) {
    const Material& material = scene.material;
    unknowns.push_back(body_unknown("youngs_modulus", "kPa", material.youngs_modulus, 0.05 * material.youngs_modulus,
                                    20.0 * material.youngs_modulus, true, 0.5));
    unknowns.push_back(body_unknown("poissons_ratio", "1", material.poissons_ratio, 0.2, 0.496, false, 0.04));
  }
  for (const Effect* effect : hypothesis.effects) {
    const std::vector<double> neutral = effect->neutral(scene);
    for (std::size_t k = 0; k < neutral.size(); ++k) {
      const EffectParameter& p = effect->parameters()[k];
      const std::string name = model_parameter(*effect, p);
      const bool is_fixed = std::any_of(hypothesis.fixed.begin(), hypothesis.fixed.end(),
                                        [&name](const auto& fixed) { return fixed.first == name; });
      if (is_fixed) continue;
      Unknown unknown = body_unknown(name, p.unit, neutral[k], p.lowest, p.highest, p.logarithmic, p.typical);
      if (is_place(p.name) && p.unit == "mm") {
        // Inside of the body, as likely here as there.
        const int axis = p.name.back() - 'x';
        unknown.lowest = scene.mesh.rest.col(axis).minCoeff();
        unknown.highest = scene.mesh.rest.col(axis).maxCoeff();
        unknown.prior_sd = reach_of(scene);
      }
      unknowns.push_back(std::move(unknown));
    }
  }
  const std::vector<std::string> names = fault_names(hypothesis.slips, scene);
  const auto add_fault = [&](std::size_t fault, const std::string& unit, double limit, double sd) {
    unknowns.push_back(fault_unknown(names[fault], unit, static_cast<int>(fault), limit, sd));
  };
  if (hypothesis.latency) add_fault(0, "s", 0.5, 0.1);
  if (hypothesis.registration) {
    for (std::size_t axis = 0; axis < 3; ++axis) add_fault(1 + axis, "rad", 0.5, 3.0 * kDegree);
    for (std::size_t axis = 0; axis < 3; ++axis) add_fault(4 + axis, "mm", 50.0, 3.0);
  }
  for (std::size_t fault = 7; fault < names.size(); ++fault) add_fault(fault, "mm", 50.0, 5.0);
  for (int k = 0; k < hypothesis.releases; ++k)
    unknowns.push_back(fault_unknown("release." + std::to_string(k), "s", -1 - k, 0.1, 0.02));
  Unknown discretisation{"discretisation", "1", Unknown::Source::discretisation, 0, 1.0, -1.0, 3.0, false, 1.0,
                         discretisation_sd};
  unknowns.push_back(discretisation);
  return unknowns;
}

MeasurementFaults faults_of(const Hypothesis& hypothesis, const std::vector<Unknown>& unknowns) {
  MeasurementFaults faults;
  faults.slips = hypothesis.slips;
  faults.releases.assign(static_cast<std::size_t>(hypothesis.releases), 0.0);
  for (const Unknown& unknown : unknowns)
    if (unknown.source == Unknown::Source::fault) fault_number(faults, unknown.fault) = unknown.value;
  return faults;
}

void begin_at(const std::vector<std::pair<std::string, double>>& start, std::vector<Unknown>& unknowns) {
  for (const auto& [name, value] : start)
    for (Unknown& unknown : unknowns) {
      if (unknown.name != name) continue;
      unknown.value = std::clamp(value, unknown.lowest, unknown.highest);
      // Every place and axis is as likely as any other: nothing pulls away from where the search
      // begins.
      if (is_place(name.substr(name.find('.') + 1))) unknown.prior = unknown.fitted();
    }
}

double penalty_of(const std::vector<Unknown>& unknowns) {
  double sum = 0.0;
  for (const Unknown& u : unknowns) sum += std::pow((u.fitted() - u.prior) / u.prior_sd, 2);
  return sum;
}

Eigen::MatrixXd with_prior(const Eigen::MatrixXd& normal, const std::vector<Unknown>& unknowns) {
  Eigen::MatrixXd sum = normal;
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    sum(at, at) += 1.0 / (unknowns[j].prior_sd * unknowns[j].prior_sd);
  }
  return sum;
}

Eigen::VectorXd pull_of_prior(const std::vector<Unknown>& unknowns) {
  Eigen::VectorXd pull(static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t j = 0; j < unknowns.size(); ++j)
    pull[static_cast<Eigen::Index>(j)] =
        (unknowns[j].prior - unknowns[j].fitted()) / (unknowns[j].prior_sd * unknowns[j].prior_sd);
  return pull;
}

}  // namespace tissued::core
