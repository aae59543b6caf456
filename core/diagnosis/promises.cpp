#include "core/diagnosis/promises.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/diagnosis/evaluator.hpp"

namespace tissued::core {

namespace {

constexpr double kLargestStep = 1.2;  // of a first step, in what is typical

// After one step from where the last effect is absent, for every start of it: one evaluation for all.
std::vector<Promise> linear_promises(const FitData& data, const Hypothesis& hypothesis,
                                     const std::vector<Values>& starts) {
  const Effect& effect = *hypothesis.effects.back();
  const Scene& scene = data.session->scene;
  const Channels channels = channels_of(scene);
  const EffectParameter& parameter = effect.parameters()[static_cast<std::size_t>(effect.amplitude())];
  const std::string amplitude = model_parameter(effect, parameter), prefix = std::string(effect.kind()) + ".";
  const double neutral = effect.neutral(scene)[static_cast<std::size_t>(effect.amplitude())];
  Evaluator evaluator(data, hypothesis);
  std::vector<Unknown> unknowns = unknowns_of(hypothesis, data.session->scene, data.correction_sd);
  begin_at(starts.front(), unknowns);
  std::erase_if(unknowns, [&](const Unknown& unknown) {
    if (!unknown.name.starts_with(prefix)) return false;
    evaluator.set(unknown.name, unknown.name == amplitude ? neutral : unknown.value);
    return true;
  });
  const double step = kStepOfDifference * parameter.typical;
  for (const auto& start : starts) {
    PathParameter column{amplitude, step, {}};
    for (const auto& [name, value] : start)
      if (name.starts_with(prefix) && name != amplitude) column.with.emplace_back(name, value);
    evaluator.add_column(std::move(column));
  }
  std::vector<Promise> promises;
  Fit at;
  if (!evaluator.run(unknowns, true, at)) return promises;
  const ErrorModel errors = raised(data.errors, channels, normal_equations(data.errors, pointers_to(at.residuals)));
  const NormalEquations equations = normal_equations(errors, pointers_to(at.residuals));
  const auto shared = static_cast<Eigen::Index>(unknowns.size());
  const Eigen::MatrixXd precision = with_prior(equations.normal.topLeftCorner(shared, shared), unknowns);
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  const Eigen::VectorXd pull = equations.gradient.head(shared) + pull_of_prior(unknowns);
  const double base = equations.chi_square - pull.dot(factor.solve(pull));
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Eigen::Index j = shared + static_cast<Eigen::Index>(i);
    const Eigen::VectorXd cross = equations.normal.col(j).head(shared), solved = factor.solve(cross);
    const double own = equations.gradient[j] - solved.dot(pull);
    const double stiffness = equations.normal(j, j) - solved.dot(cross) + 1.0 / (parameter.typical * parameter.typical);
    // As far as a linear step can be trusted.
    const double limit = kLargestStep * parameter.typical;
    const double change = std::clamp(own / stiffness, -limit, limit);
    const double value = parameter.logarithmic ? neutral * std::exp(change) : neutral + change;
    promises.push_back({i, base - own * own / stiffness, std::clamp(value, parameter.lowest, parameter.highest)});
  }
  return promises;
}

}  // namespace

std::vector<Promise> most_promising(const FitData& data, const Hypothesis& hypothesis,
                                    const std::vector<Values>& starts) {
  std::vector<Promise> promises;
  if (!hypothesis.effects.empty() && hypothesis.effects.back()->amplitude() >= 0) {
    promises = linear_promises(data, hypothesis, starts);
  } else {
    const Channels channels = channels_of(data.session->scene);
    Evaluator evaluator(data, hypothesis);
    ErrorModel errors;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      Fit at;
      at.unknowns = unknowns_of(hypothesis, data.session->scene, data.correction_sd);
      begin_at(starts[i], at.unknowns);
      if (!evaluator.run(at.unknowns, true, at)) continue;
      // One measure for all of them.
      if (errors.noise.size() == 0)
        errors = raised(data.errors, channels, normal_equations(data.errors, pointers_to(at.residuals)));
      const NormalEquations equations = normal_equations(errors, pointers_to(at.residuals));
      const Eigen::VectorXd step = step_of(equations, at.unknowns, 1e-2);
      const Eigen::VectorXd pull = equations.gradient + pull_of_prior(at.unknowns);
      promises.push_back({i,
                          equations.chi_square + penalty_of(at.unknowns) - 2.0 * pull.dot(step) +
                              step.dot(with_prior(equations.normal, at.unknowns) * step),
                          std::numeric_limits<double>::quiet_NaN()});
    }
  }
  std::stable_sort(promises.begin(), promises.end(),
                   [](const Promise& a, const Promise& b) { return a.chi_square < b.chi_square; });
  return promises;
}

}  // namespace tissued::core
