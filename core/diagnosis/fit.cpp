#include "core/diagnosis/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/diagnosis/evaluator.hpp"

namespace tissued::core {

namespace {

// Each trial as the others, and the priors, predict it: one linear step from the fit of all.
double left_out(const FitData& data, const Fit& fit) {
  if (fit.residuals.size() < 2) return fit.chi_square;
  double sum = 0.0;
  for (const TrialResidual& trial : fit.residuals) {
    const auto others = pointers_to(fit.residuals, trial.trial);
    const NormalEquations rest = normal_equations(data.errors, others);
    const Eigen::VectorXd step =
        with_prior(rest.normal, fit.unknowns).llt().solve(rest.gradient + pull_of_prior(fit.unknowns));
    const TrialResidual* only = &trial;
    const NormalEquations own = normal_equations(data.errors, {&only, 1});
    sum += own.chi_square - 2.0 * step.dot(own.gradient) + step.dot(own.normal * step);
  }
  return sum;
}

void conclude(const FitData& data, const NormalEquations& equations, Fit& fit) {
  fit.solved = true;
  fit.chi_square = equations.chi_square;
  fit.count = equations.count;
  fit.penalty = penalty_of(fit.unknowns);
  fit.chi_square_of_channel = equations.chi_square_of_channel;
  const Eigen::MatrixXd precision = with_prior(equations.normal, fit.unknowns);
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  fit.covariance = factor.solve(Eigen::MatrixXd::Identity(precision.rows(), precision.cols()));
  double log_determinant = 0.0;
  for (Eigen::Index j = 0; j < precision.rows(); ++j)
    log_determinant += 2.0 * std::log(factor.matrixLLT()(j, j) * fit.unknowns[j].prior_sd);
  fit.log_evidence = -0.5 * (fit.chi_square + fit.penalty + log_determinant);
  fit.left_out_chi_square = left_out(data, fit);
}

Fit begun(const FitData& data, const Hypothesis& hypothesis, const Values& start) {
  Fit fit;
  fit.hypothesis = hypothesis;
  fit.unknowns = unknowns_of(hypothesis, data.session->scene, data.correction_sd);
  begin_at(start, fit.unknowns);
  return fit;
}

const Unknown& find(const Fit& fit, const std::string& name, std::size_t* index = nullptr) {
  for (std::size_t j = 0; j < fit.unknowns.size(); ++j) {
    if (fit.unknowns[j].name != name) continue;
    if (index != nullptr) *index = j;
    return fit.unknowns[j];
  }
  throw std::out_of_range(name);
}

}  // namespace

double Fit::value(const std::string& name) const { return find(*this, name).value; }

bool Fit::has(const std::string& name) const {
  return std::any_of(unknowns.begin(), unknowns.end(), [&](const Unknown& u) { return u.name == name; });
}

double Fit::sd(const std::string& name) const { return sd(Values{{name, 1.0}}); }

double Fit::sd(const Values& slopes) const {
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(covariance.rows());
  for (const auto& [name, by_value] : slopes) {
    std::size_t j = 0;
    const Unknown& unknown = find(*this, name, &j);
    slope[static_cast<Eigen::Index>(j)] = by_value * unknown.slope();
  }
  // A fit that leaves more than noise and elements account for knows its numbers less well.
  const double excess = count > 0 ? chi_square / count : 1.0;
  return std::sqrt(std::max(kTemperature, excess) * slope.dot(covariance * slope));
}

std::vector<double> effect_values(const Effect& effect, const Fit& fit, const Scene& scene) {
  std::vector<double> values = effect.neutral(scene);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::string name = model_parameter(effect, effect.parameters()[k]);
    for (const auto& [fixed, value] : fit.hypothesis.fixed)
      if (fixed == name) values[k] = value;
    if (fit.has(name)) values[k] = fit.value(name);
  }
  return values;
}

void set_numbers(const Hypothesis& hypothesis, const std::vector<Unknown>& unknowns, PathSolver& solver) {
  for (const auto& [name, value] : hypothesis.fixed) solver.set_parameter(name, value);
  for (const Unknown& unknown : unknowns)
    if (unknown.source == Unknown::Source::body) solver.set_parameter(unknown.name, unknown.value);
}

Fit assess(const FitData& data, const Hypothesis& hypothesis, const Values& values) {
  Fit fit = begun(data, hypothesis, values);
  Evaluator evaluator(data, fit.hypothesis);
  if (!evaluator.run(fit.unknowns, true, fit)) return fit;
  conclude(data, normal_equations(data.errors, pointers_to(fit.residuals)), fit);
  return fit;
}

Fit assess_unhurried(FitData data, const Hypothesis& hypothesis, const Values& values) {
  data.stop = nullptr;
  return assess(data, hypothesis, values);
}

Eigen::VectorXd step_of(const NormalEquations& equations, const std::vector<Unknown>& unknowns, double damping) {
  Eigen::MatrixXd damped = with_prior(equations.normal, unknowns);
  damped.diagonal() *= 1.0 + damping;
  Eigen::VectorXd right = equations.gradient + pull_of_prior(unknowns);
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const Unknown& u = unknowns[j];
    const auto at = static_cast<Eigen::Index>(j);
    if (!((u.value <= u.lowest && right[at] < 0.0) || (u.value >= u.highest && right[at] > 0.0))) continue;
    damped.row(at).setZero();
    damped.col(at).setZero();
    damped(at, at) = 1.0;
    right[at] = 0.0;
  }
  return damped.llt().solve(right);
}

Fit fit(const FitData& data, const Hypothesis& hypothesis, const Values& start, const FitControl& control) {
  Fit best = begun(data, hypothesis, start);
  Evaluator evaluator(data, best.hypothesis);
  if (!evaluator.run(best.unknowns, true, best)) return best;
  const Channels channels = channels_of(data.session->scene);
  double damping = 1e-3, least_damping = 1e-6;
  while (best.evaluations < control.most_evaluations) {
    const ErrorModel errors = raised(data.errors, channels, normal_equations(data.errors, pointers_to(best.residuals)));
    const NormalEquations equations = normal_equations(errors, pointers_to(best.residuals));
    const Eigen::VectorXd step = step_of(equations, best.unknowns, damping);
    if ((equations.gradient + pull_of_prior(best.unknowns)).dot(step) < control.worthwhile) break;
    Fit trial = best;
    for (std::size_t j = 0; j < trial.unknowns.size(); ++j)
      trial.unknowns[j].set_fitted(trial.unknowns[j].fitted() + step[static_cast<Eigen::Index>(j)]);
    const bool solved = evaluator.run(trial.unknowns, true, trial);
    best.stopped = data.stop != nullptr && data.stop->load(std::memory_order_relaxed);
    if (best.stopped) break;
    const auto objective = [&](const Fit& at) {
      return normal_equations(errors, pointers_to(at.residuals)).chi_square + penalty_of(at.unknowns);
    };
    if (solved && objective(trial) < equations.chi_square + penalty_of(best.unknowns)) {
      best = std::move(trial);
      damping = std::max(0.1 * damping, least_damping);
      continue;
    }
    best.evaluations = trial.evaluations;
    damping = std::max(10.0 * damping, 0.1);
    if (!solved) least_damping = damping;  // a step as bold would end where the body folds again, which takes long
    if (damping > 1e4) break;
  }
  conclude(data, normal_equations(data.errors, pointers_to(best.residuals)), best);
  return best;
}

}  // namespace tissued::core
