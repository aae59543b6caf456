#include "core/diagnosis/evaluator.hpp"

#include <algorithm>
#include <limits>

#include "core/diagnosis/placement.hpp"

namespace tissued::core {

Evaluator::Evaluator(const FitData& data, const Hypothesis& hypothesis) : data_(&data), hypothesis_(&hypothesis) {
  const std::size_t count = data.threads > 1 ? data.paths.size() : 1;
  for (std::size_t k = 0; k < count; ++k) solvers_.emplace_back(data.session->scene, hypothesis.effects, data.element);
  for (const auto& [name, value] : hypothesis.fixed) set(name, value);
}

bool Evaluator::run(const std::vector<Unknown>& unknowns, bool differentiate, Fit& fit) {
  // Later runs begin where the one before ended, which takes less than from rest. Numbers by which the body folds would
  // take ten times as much, to no end.
  constexpr int kPatience = 2;
  std::vector<PathParameter> parameters;
  for (const Unknown& unknown : unknowns) {
    if (unknown.source != Unknown::Source::body) continue;
    set(unknown.name, unknown.value);
    const double step = kStepOfDifference * (unknown.logarithmic ? unknown.value : unknown.prior_sd);
    parameters.push_back({unknown.name, unknown.value + step > unknown.highest ? -step : step, {}});
  }
  parameters.insert(parameters.end(), columns_.begin(), columns_.end());
  if (!differentiate) parameters.clear();
  const int trials = static_cast<int>(data_->paths.size());
  fit.answers.resize(data_->paths.size());
  fit.residuals.resize(data_->paths.size());
  ++fit.evaluations;
  std::vector<int> corrections(data_->paths.size(), 0);
  std::vector<std::uint8_t> is_solved(data_->paths.size(), 0);
#pragma omp parallel for schedule(dynamic, 1) num_threads(data_->threads) if (solvers_.size() > 1)
  for (int k = 0; k < trials; ++k) {
    if (data_->stop != nullptr && data_->stop->load(std::memory_order_relaxed)) continue;
    PathSolver& solver = solvers_[solvers_.size() > 1 ? k : 0];
    PathAnswer& answer = fit.answers[k];
    if (!usual_corrections_.empty()) solver.set_patience(kPatience * usual_corrections_[k]);
    if (!solver.solve(data_->paths[k], k, parameters, answer)) {
#pragma omp critical
      fit.trouble = data_->session->trials[k].name + ": " + solver.trouble();
      continue;
    }
    if (!answer.values.allFinite()) {
#pragma omp critical
      fit.trouble = data_->session->trials[k].name + ": the answer is not finite";
      continue;
    }
    corrections[k] = solver.corrections();
    compare(k, unknowns, differentiate, answer, fit.residuals[k]);
    answer.by_parameter.clear();
    is_solved[k] = 1;
  }
  if (std::count(is_solved.begin(), is_solved.end(), 1) != trials) return false;
  if (usual_corrections_.empty()) usual_corrections_ = std::move(corrections);
  if (!data_->placement.empty()) take_off(unknowns, differentiate, fit);
  return true;
}

// What the markers' places do; of derivatives where it matters, by faults that move all markers at once.
void Evaluator::take_off(const std::vector<Unknown>& unknowns, bool differentiate, Fit& fit) const {
  const Channels channels = channels_of(data_->session->scene);
  if (differentiate)
    for (std::size_t j = 0; j < unknowns.size(); ++j)
      if (unknowns[j].source == Unknown::Source::fault)
        take_off_placement(data_->errors, channels, data_->paths, data_->placement, data_->session->trials,
                           fit.residuals, j);
  take_off_placement(data_->errors, channels, data_->paths, data_->placement, data_->session->trials, fit.residuals);
}

// Answers with forces as finer elements have them.
RowMatrix Evaluator::scaled(int k, double share, const RowMatrix& answers) const {
  const Channels channels = channels_of(data_->session->scene);
  RowMatrix out = answers;
  for (int pad = 0; pad < channels.pads; ++pad)
    out.middleCols<3>(channels.of_force(pad)).array().colwise() *= data_->force_factor[k].col(pad).array().pow(share);
  return out;
}

void Evaluator::compare(int k, const std::vector<Unknown>& unknowns, bool differentiate, const PathAnswer& answer,
                        TrialResidual& out) const {
  const RecordedTrial& trial = data_->session->trials[k];
  const LoadPath& path = data_->paths[k];
  const auto record = [&](const RowMatrix& answers, const MeasurementFaults& faults) {
    return recorded(trial, k, path, data_->session->scene, answers, faults);
  };
  const MeasurementFaults faults = faults_of(*hypothesis_, unknowns);
  const RowMatrix& correction = data_->correction[k];
  const double share = unknowns.back().value;
  const RowMatrix corrected = scaled(k, share, answer.values) + share * correction;
  const RowMatrix predicted = record(corrected, faults);
  out.trial = k;
  out.residual = trial.seen - predicted;
  for (int f = 0; f < trial.frame_count(); ++f)
    if (!path.shows(trial.time[f])) out.residual.row(f).setConstant(std::numeric_limits<double>::quiet_NaN());
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
      const double step = unknown.fault <= 0 ? 5e-4 : 1e-5;
      fault_number(shifted, unknown.fault) += step;
      const RowMatrix after = record(corrected, shifted);
      fault_number(shifted, unknown.fault) -= 2.0 * step;
      out.derivatives.push_back((after - record(corrected, shifted)) / (2.0 * step));
    }
  }
  for (; body < answer.by_parameter.size(); ++body)
    out.derivatives.push_back(record(scaled(k, share, answer.by_parameter[body]), faults) - nothing);
}

}  // namespace tissued::core
