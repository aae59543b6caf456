#include "core/diagnosis/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tissued::core {

namespace {

constexpr double kLargestStep = 1.2;        // likewise, of a first step
constexpr double kStepOfDifference = 1e-5;  // of what is typical
const std::string kDiscretisation = "discretisation";

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

std::vector<Unknown> unknowns_of(const Hypothesis& hypothesis, const FitData& data) {
  const Scene& scene = data.session->scene;
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
      if (p.fixed || is_fixed) continue;
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
  Unknown discretisation{kDiscretisation,   "1", Unknown::Source::discretisation, 0, 1.0, -1.0, 3.0, false, 1.0,
                         data.correction_sd};
  unknowns.push_back(discretisation);
  return unknowns;
}

// Evaluates a hypothesis with given unknowns; owns its body.
class Evaluator {
 public:
  Evaluator(const FitData& data, const Hypothesis& hypothesis)
      : data_(&data), hypothesis_(&hypothesis), solver_(data.session->scene, hypothesis.effects, data.element) {
    for (const auto& [name, value] : hypothesis.fixed) solver_.set_parameter(name, value);
  }

  // Derivatives that are taken beside those by unknowns.
  void add_column(PathParameter column) { columns_.push_back(std::move(column)); }
  void set(const std::string& name, double value) { solver_.set_parameter(name, value); }

  bool run(const std::vector<Unknown>& unknowns, bool differentiate, Fit& fit) {
    std::vector<PathParameter> parameters;
    for (const Unknown& unknown : unknowns) {
      if (unknown.source != Unknown::Source::body) continue;
      solver_.set_parameter(unknown.name, unknown.value);
      const double step = kStepOfDifference * (unknown.logarithmic ? unknown.value : unknown.prior_sd);
      parameters.push_back({unknown.name, unknown.value + step > unknown.highest ? -step : step, {}});
    }
    parameters.insert(parameters.end(), columns_.begin(), columns_.end());
    if (!differentiate) parameters.clear();
    const int trials = static_cast<int>(data_->paths.size());
    fit.answers.resize(data_->paths.size());
    fit.residuals.resize(data_->paths.size());
    ++fit.evaluations;
    for (int k = 0; k < trials; ++k) {
      if (data_->stop != nullptr && data_->stop->load(std::memory_order_relaxed)) return false;
      PathAnswer& answer = fit.answers[k];
      if (!solver_.solve(data_->paths[k], k, parameters, answer)) {
        fit.trouble = data_->session->trials[k].name + ": " + solver_.trouble();
        return false;
      }
      compare(k, unknowns, differentiate, answer, fit.residuals[k]);
      answer.by_parameter.clear();
    }
    return true;
  }

 private:
  MeasurementFaults faults_of(const std::vector<Unknown>& unknowns) const {
    MeasurementFaults faults;
    faults.slips = hypothesis_->slips;
    for (const Unknown& unknown : unknowns)
      if (unknown.source == Unknown::Source::fault) fault_number(faults, unknown.fault) = unknown.value;
    return faults;
  }

  // Answers with forces as finer elements have them.
  RowMatrix scaled(int k, double share, const RowMatrix& answers) const {
    const Channels channels = channels_of(data_->session->scene);
    RowMatrix out = answers;
    for (int pad = 0; pad < channels.pads; ++pad)
      out.middleCols<3>(channels.of_force(pad)).array().colwise() *= data_->force_factor[k].col(pad).array().pow(share);
    return out;
  }

  void compare(int k, const std::vector<Unknown>& unknowns, bool differentiate, const PathAnswer& answer,
               TrialResidual& out) const {
    const RecordedTrial& trial = data_->session->trials[k];
    const LoadPath& path = data_->paths[k];
    const auto record = [&](const RowMatrix& answers, const MeasurementFaults& faults) {
      return recorded(trial, k, path, data_->session->scene, answers, faults);
    };
    const MeasurementFaults faults = faults_of(unknowns);
    const RowMatrix& correction = data_->correction[k];
    const double share = unknowns.back().value;
    const RowMatrix corrected = scaled(k, share, answer.values) + share * correction;
    const RowMatrix predicted = record(corrected, faults);
    out.trial = k;
    out.residual = trial.seen - predicted;
    out.load.resize(trial.frame_count());
    for (int f = 0; f < trial.frame_count(); ++f)
      out.load[f] = path.peak_load() > 0.0 ? path.load(trial.time[f]) / path.peak_load() : 0.0;
    out.derivatives.clear();
    if (!differentiate) return;
    const RowMatrix nothing = record(RowMatrix::Zero(answer.values.rows(), answer.values.cols()), faults);
    std::size_t body = 0;
    for (const Unknown& unknown : unknowns) {
      if (unknown.source == Unknown::Source::body) {
        out.derivatives.push_back(unknown.slope() *
                                  (record(scaled(k, share, answer.by_parameter[body++]), faults) - nothing));
      } else if (unknown.source == Unknown::Source::discretisation) {
        constexpr double kStep = 1e-4;
        const RowMatrix by_share = (scaled(k, share + kStep, answer.values) - scaled(k, share, answer.values)) / kStep;
        out.derivatives.push_back(record(correction + by_share, faults) - nothing);
      } else {
        MeasurementFaults shifted = faults;
        // Of a latency half a millisecond to both sides: answers are interpolated linearly.
        const double step = unknown.fault == 0 ? 5e-4 : 1e-5;
        fault_number(shifted, unknown.fault) += step;
        const RowMatrix after = record(corrected, shifted);
        fault_number(shifted, unknown.fault) -= 2.0 * step;
        out.derivatives.push_back((after - record(corrected, shifted)) / (2.0 * step));
      }
    }
    for (; body < answer.by_parameter.size(); ++body)
      out.derivatives.push_back(record(scaled(k, share, answer.by_parameter[body]), faults) - nothing);
  }

  const FitData* data_;
  const Hypothesis* hypothesis_;
  PathSolver solver_;
  std::vector<PathParameter> columns_;
};

double penalty_of(const std::vector<Unknown>& unknowns) {
  double sum = 0.0;
  for (const Unknown& u : unknowns) sum += std::pow((u.fitted() - u.prior) / u.prior_sd, 2);
  return sum;
}

std::vector<const TrialResidual*> pointers_to(const std::vector<TrialResidual>& residuals, int but = -1) {
  std::vector<const TrialResidual*> out;
  for (const TrialResidual& residual : residuals)
    if (residual.trial != but) out.push_back(&residual);
  return out;
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

// Far from the truth noise is no measure of the misfit, and what is allowed for discretisation would be used up to
// hide it: noise is raised to what is left, for each kind of channel.
ErrorModel raised(const ErrorModel& errors, const Channels& channels, const NormalEquations& equations) {
  const auto kind_of = [&channels](int c) { return channels.is_marker(c) ? 0 : channels.is_force(c) ? 1 : 2; };
  std::array<double, 3> square{}, count{};
  for (int c = 0; c < channels.count(); ++c) {
    square[kind_of(c)] += equations.chi_square_of_channel[c];
    count[kind_of(c)] += equations.count_of_channel[c];
  }
  ErrorModel out = errors;
  for (int c = 0; c < channels.count(); ++c) {
    const int kind = kind_of(c);
    if (square[kind] > count[kind]) out.noise[c] *= std::sqrt(square[kind] / count[kind]);
  }
  return out;
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

// Of Levenberg and Marquardt; unknowns at a bound that the step would leave stay there.
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

void begin_at(const std::vector<std::pair<std::string, double>>& start, std::vector<Unknown>& unknowns) {
  for (const auto& [name, value] : start)
    for (Unknown& unknown : unknowns) {
      if (unknown.name != name) continue;
      unknown.value = std::clamp(value, unknown.lowest, unknown.highest);
      // Every place and axis is as likely as any other: nothing pulls away from where the search begins.
      if (is_place(name.substr(name.find('.') + 1))) unknown.prior = unknown.fitted();
    }
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

double Unknown::fitted() const { return logarithmic ? std::log(value) : value; }

void Unknown::set_fitted(double fitted) {
  value = std::clamp(logarithmic ? std::exp(fitted) : fitted, lowest, highest);
}

double Fit::value(const std::string& name) const { return find(*this, name).value; }

bool Fit::has(const std::string& name) const {
  return std::any_of(unknowns.begin(), unknowns.end(), [&](const Unknown& u) { return u.name == name; });
}

double Fit::sd(const std::string& name) const {
  std::size_t j = 0;
  const Unknown& unknown = find(*this, name, &j);
  const auto at = static_cast<Eigen::Index>(j);
  return unknown.slope() * std::sqrt(covariance(at, at));
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

Fit assess(const FitData& data, const Hypothesis& hypothesis,
           const std::vector<std::pair<std::string, double>>& values) {
  Fit fit;
  fit.hypothesis = hypothesis;
  fit.unknowns = unknowns_of(hypothesis, data);
  begin_at(values, fit.unknowns);
  Evaluator evaluator(data, fit.hypothesis);
  if (!evaluator.run(fit.unknowns, true, fit)) return fit;
  conclude(data, normal_equations(data.errors, pointers_to(fit.residuals)), fit);
  return fit;
}

namespace {

// After one step from where the last effect is absent, for every start of it: one evaluation for all.
std::vector<Promise> linear_promises(const FitData& data, const Hypothesis& hypothesis,
                                     const std::vector<std::vector<std::pair<std::string, double>>>& starts) {
  const Effect& effect = *hypothesis.effects.back();
  const Scene& scene = data.session->scene;
  const Channels channels = channels_of(scene);
  const EffectParameter& parameter = effect.parameters()[static_cast<std::size_t>(effect.amplitude())];
  const std::string amplitude = model_parameter(effect, parameter), prefix = std::string(effect.kind()) + ".";
  const double neutral = effect.neutral(scene)[static_cast<std::size_t>(effect.amplitude())];
  Evaluator evaluator(data, hypothesis);
  std::vector<Unknown> unknowns = unknowns_of(hypothesis, data);
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
                                    const std::vector<std::vector<std::pair<std::string, double>>>& starts) {
  std::vector<Promise> promises;
  if (!hypothesis.effects.empty() && hypothesis.effects.back()->amplitude() >= 0) {
    promises = linear_promises(data, hypothesis, starts);
  } else {
    const Channels channels = channels_of(data.session->scene);
    Evaluator evaluator(data, hypothesis);
    ErrorModel errors;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      Fit at;
      at.unknowns = unknowns_of(hypothesis, data);
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

Fit fit(const FitData& data, const Hypothesis& hypothesis, const std::vector<std::pair<std::string, double>>& start,
        const FitControl& control) {
  Fit best;
  best.hypothesis = hypothesis;
  best.unknowns = unknowns_of(hypothesis, data);
  begin_at(start, best.unknowns);
  Evaluator evaluator(data, best.hypothesis);
  if (!evaluator.run(best.unknowns, true, best)) return best;
  const Channels channels = channels_of(data.session->scene);
  double damping = 1e-3;
  while (best.evaluations < control.most_evaluations) {
    const ErrorModel errors = raised(data.errors, channels, normal_equations(data.errors, pointers_to(best.residuals)));
    const NormalEquations equations = normal_equations(errors, pointers_to(best.residuals));
    const Eigen::VectorXd step = step_of(equations, best.unknowns, damping);
    if ((equations.gradient + pull_of_prior(best.unknowns)).dot(step) < control.worthwhile) break;
    Fit trial = best;
    for (std::size_t j = 0; j < trial.unknowns.size(); ++j)
      trial.unknowns[j].set_fitted(trial.unknowns[j].fitted() + step[static_cast<Eigen::Index>(j)]);
    const bool solved = evaluator.run(trial.unknowns, true, trial);
    if (data.stop != nullptr && data.stop->load(std::memory_order_relaxed)) break;
    const auto objective = [&](const Fit& at) {
      return normal_equations(errors, pointers_to(at.residuals)).chi_square + penalty_of(at.unknowns);
    };
    if (solved && objective(trial) < equations.chi_square + penalty_of(best.unknowns)) {
      best = std::move(trial);
      damping = std::max(0.1 * damping, 1e-6);
      continue;
    }
    best.evaluations = trial.evaluations;
    damping = std::max(10.0 * damping, 0.1);
    if (damping > 1e4) break;
  }
  conclude(data, normal_equations(data.errors, pointers_to(best.residuals)), best);
  return best;
}

}  // namespace tissued::core
