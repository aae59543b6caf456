#include "core/diagnosis/promises.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/diagnosis/candidate.hpp"
#include "core/diagnosis/evaluator.hpp"

namespace tissued::core {

namespace {

constexpr double kLargestStep = 1.2;  // of a first step, in what is typical

// A start of an effect that is absent: what its amplitude is differentiated by, and how far it may go in one step.
struct Column {
  const Effect* effect;
  const EffectParameter* amplitude;
  double neutral;
  PathParameter parameter;

  // In the fitted scale.
  double change_to(double value) const { return amplitude->logarithmic ? std::log(value / neutral) : value - neutral; }
  double changed_by(double change) const {
    return amplitude->logarithmic ? neutral * std::exp(change) : neutral + change;
  }
};

std::string prefix_of(const Effect& effect) { return std::string(effect.kind()) + "."; }

Column column_of(const Effect& effect, const Values& start, const Scene& scene) {
  const auto index = static_cast<std::size_t>(effect.amplitude());
  const EffectParameter& amplitude = effect.parameters()[index];
  const std::string name = model_parameter(effect, amplitude);
  Column column{&effect, &amplitude, effect.neutral(scene)[index], {name, kStepOfDifference * amplitude.typical, {}}};
  for (const auto& [of, value] : start)
    if (of.starts_with(prefix_of(effect)) && of != name) column.parameter.with.emplace_back(of, value);
  return column;
}

// What is left after one step from where the effects of the columns are absent, and the amplitude there: one evaluation
// for all. hypothesis: has these effects, too; unknowns: of the others. Empty where there is no equilibrium.
std::vector<Promise> promises_of(const FitData& data, const Hypothesis& hypothesis,
                                 const std::vector<Unknown>& unknowns, const std::vector<Column>& columns) {
  const Scene& scene = data.session->scene;
  Evaluator evaluator(data, hypothesis);
  for (const Column& column : columns) {
    const std::vector<double> neutral = column.effect->neutral(scene);
    for (std::size_t k = 0; k < neutral.size(); ++k)
      evaluator.set(model_parameter(*column.effect, column.effect->parameters()[k]), neutral[k]);
  }
  for (const Column& column : columns) evaluator.add_column(column.parameter);
  std::vector<Promise> promises;
  Fit at;
  if (!evaluator.run(unknowns, true, at)) return promises;
  const ErrorModel errors =
      raised(data.errors, channels_of(scene), normal_equations(data.errors, pointers_to(at.residuals)));
  const NormalEquations equations = normal_equations(errors, pointers_to(at.residuals));
  const auto shared = static_cast<Eigen::Index>(unknowns.size());
  const Eigen::MatrixXd precision = with_prior(equations.normal.topLeftCorner(shared, shared), unknowns);
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  const Eigen::VectorXd pull = equations.gradient.head(shared) + pull_of_prior(unknowns);
  const double base = equations.chi_square - pull.dot(factor.solve(pull));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const EffectParameter& amplitude = *columns[i].amplitude;
    const Eigen::Index j = shared + static_cast<Eigen::Index>(i);
    const Eigen::VectorXd cross = equations.normal.col(j).head(shared), solved = factor.solve(cross);
    const double own = equations.gradient[j] - solved.dot(pull);
    const double stiffness = equations.normal(j, j) - solved.dot(cross) + 1.0 / (amplitude.typical * amplitude.typical);
    // What lies beyond a bound is no promise: fibres that weaken the body are none.
    const double step =
        std::clamp(own / stiffness, columns[i].change_to(amplitude.lowest), columns[i].change_to(amplitude.highest));
    const double gain = step * (2.0 * own - stiffness * step);
    // As far as a linear step can be trusted.
    const double limit = kLargestStep * amplitude.typical;
    promises.push_back({i, base - gain, gain, columns[i].changed_by(std::clamp(step, -limit, limit))});
  }
  return promises;
}

// For every start of the last effect.
std::vector<Promise> linear_promises(const FitData& data, const Hypothesis& hypothesis,
                                     const std::vector<Values>& starts) {
  const Effect& effect = *hypothesis.effects.back();
  std::vector<Unknown> unknowns = unknowns_of(hypothesis, data.session->scene, data.correction_sd);
  begin_at(starts.front(), unknowns);
  std::erase_if(unknowns, [&](const Unknown& unknown) { return unknown.name.starts_with(prefix_of(effect)); });
  std::vector<Column> columns;
  for (const Values& start : starts) columns.push_back(column_of(effect, start, data.session->scene));
  return promises_of(data, hypothesis, unknowns, columns);
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
                          std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()});
    }
  }
  std::stable_sort(promises.begin(), promises.end(),
                   [](const Promise& a, const Promise& b) { return a.chi_square < b.chi_square; });
  return promises;
}

double promise_all(const FitData& data, const Candidate& base, std::vector<Candidate>& added) {
  Hypothesis hypothesis = base.hypothesis;
  std::vector<Unknown> unknowns = unknowns_of(hypothesis, data.session->scene, data.correction_sd);
  begin_at(values_of(base.best()), unknowns);
  std::vector<Column> columns;
  std::vector<std::pair<Candidate*, std::size_t>> owners;
  for (Candidate& candidate : added) {
    candidate.promises.clear();
    const Effect& effect = *candidate.hypothesis.effects.back();
    if (effect.amplitude() < 0) continue;
    hypothesis.effects.push_back(&effect);
    for (std::size_t i = 0; i < candidate.starts.size(); ++i) {
      columns.push_back(column_of(effect, candidate.starts[i], data.session->scene));
      owners.emplace_back(&candidate, i);
    }
  }
  const std::vector<Promise> promises = promises_of(data, hypothesis, unknowns, columns);
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < promises.size(); ++i) {
    owners[i].first->promises.push_back(promises[i]);
    owners[i].first->promises.back().start = owners[i].second;
    best = std::min(best, promises[i].chi_square);
  }
  for (Candidate& candidate : added)
    std::stable_sort(candidate.promises.begin(), candidate.promises.end(),
                     [](const Promise& a, const Promise& b) { return a.chi_square < b.chi_square; });
  return best;
}

double promise_beside(const FitData& exact, const Candidate& base, Candidate& candidate) {
  Values start;
  for (const Unknown& unknown : base.exact.unknowns) start.emplace_back(unknown.name, unknown.value);
  for (const auto& [name, value] : values_of(candidate.fast))
    if (!base.exact.has(name)) start.emplace_back(name, value);
  if (candidate.hypothesis.effects.size() > base.hypothesis.effects.size()) {  // else it adds a fault of measurement
    const Effect& effect = *candidate.hypothesis.effects.back();
    const std::vector<double> neutral = effect.neutral(exact.session->scene);
    for (const int k : effect.amplitudes())
      for (auto& [name, value] : start)
        if (name == model_parameter(effect, effect.parameters()[k])) value = neutral[static_cast<std::size_t>(k)];
  }
  Fit at = assess(exact, candidate.hypothesis, start);
  if (!at.solved) return std::numeric_limits<double>::infinity();
  const Channels channels = channels_of(exact.session->scene);
  const ErrorModel errors = raised(exact.errors, channels, normal_equations(exact.errors, pointers_to(at.residuals)));
  const NormalEquations equations = normal_equations(errors, pointers_to(at.residuals));
  const Eigen::VectorXd step = step_of(equations, at.unknowns, 1e-3);
  const double promise = (equations.gradient + pull_of_prior(at.unknowns)).dot(step);
  // What has no amplitude is not begun where it is absent.
  const double base_now = normal_equations(errors, pointers_to(base.exact.residuals)).chi_square + base.exact.penalty;
  const double now = equations.chi_square + penalty_of(at.unknowns);
  candidate.exact = std::move(at);
  return base_now - now + promise;
}

void set_amplitude(const Effect& effect, double amplitude, Values& start) {
  if (effect.amplitude() < 0) return;
  const std::string name = model_parameter(effect, effect.parameters()[effect.amplitude()]);
  for (auto& [of, value] : start)
    if (of == name) value = amplitude;
}

}  // namespace tissued::core
