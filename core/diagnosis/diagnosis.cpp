#include "core/diagnosis/diagnosis.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/disturbance.hpp"
#include "core/diagnosis/words.hpp"

namespace tissued::core {

namespace {

// What must be met before something is said. Of 200 nulls (scripts/nulls) none comes near: the largest advantage is 7
// (98 % below 4.6), structure 0.95, ln E is off by 0.051 where forces are seen and nu by 0.013, 98 % by 0.010. All four
// are kept above that, because bodies of flesh err in more ways than ours.
constexpr double kModulusOff = 0.12;  // of the logarithm of Young's modulus: what the elements may err
constexpr double kRatioOff = 0.015;   // of Poisson's ratio, likewise
constexpr double kStructure = 1.5;    // of markers' structure_left: beyond, something is left to explain
constexpr double kSurest = 0.98;      // probability
constexpr double kSaid = 0.02;        // probability below which an alternative is not listed

const std::set<std::string> kMeasurement{"latency", "registration", "marker-slip"};

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }

// Beyond what elements may err, and beyond 95 %.
bool numbers_differ(const Fit& fit, const Scene& scene) {
  if (!fit.solved || !fit.has("youngs_modulus")) return false;
  const double modulus = std::abs(std::log(fit.value("youngs_modulus") / scene.material.youngs_modulus));
  const double modulus_sd = fit.sd("youngs_modulus") / fit.value("youngs_modulus");
  const double ratio = std::abs(fit.value("poissons_ratio") - scene.material.poissons_ratio);
  return (modulus > kModulusOff && modulus > 2.0 * modulus_sd) ||
         (ratio > kRatioOff && ratio > 2.0 * fit.sd("poissons_ratio"));
}

std::vector<RowMatrix> residuals_of(const Fit& fit) {
  std::vector<RowMatrix> out;
  for (const TrialResidual& trial : fit.residuals) out.push_back(trial.residual);
  return out;
}

Eigen::VectorXd offset_of(const FitData& data, const Fit& fit) {
  return nuisances(data.errors, pointers_to(fit.residuals)).offset;
}

// An effect is to take off more than the elements err, of the markers' misfit or, there in proportion, of the forces'.
bool matters(const SearchResult& result, const Candidate& with, const Candidate& without) {
  constexpr double kOfForces = 0.5;  // of their mean square
  if (!with.exact.solved || !without.exact.solved) return true;
  const Channels channels = channels_of(result.exact.session->scene);
  const auto misfit = [&](const Fit& fit) {
    return misfit_of(residuals_of(fit), channels, offset_of(result.exact, fit));
  };
  const Misfit before = misfit(without.exact), after = misfit(with.exact);
  const double elements = std::max(result.discretisation_mm, result.unjudged_mm);
  return std::pow(before.marker_mm, 2) - std::pow(after.marker_mm, 2) > std::pow(elements, 2) ||
         std::pow(after.force_N, 2) < kOfForces * std::pow(before.force_N, 2);
}

// The candidate that is believed: numbers alone, one effect, or more. A round adds to the likeliest of the one before,
// which need not matter alone: an effect may show itself only beside another one.
const Candidate& chosen_of(const SearchResult& result) {
  const Candidate* chosen = &result.numbers;
  for (std::size_t r = 0; r < result.rounds.size() && !result.rounds[r].empty(); ++r) {
    const Candidate& before = r == 0 ? result.numbers : result.rounds[r - 1].front();
    double gain_of_chosen = 0.0;
    for (std::size_t k = chosen->kinds.size(); k <= r; ++k) gain_of_chosen += least_gain(result, k);
    const auto is_accepted = [&](const Candidate& candidate) {
      const auto is_better_than = [&](const Candidate& other, double least) {
        return gain(result, candidate, other) >= least && matters(result, candidate, other);
      };
      const bool is_judged = r == 0 || result.compares_fast || candidate.exact.solved;
      return is_judged && is_better_than(before, least_gain(result, r)) && is_better_than(*chosen, gain_of_chosen);
    };
    const auto accepted = std::find_if(result.rounds[r].begin(), result.rounds[r].end(), is_accepted);
    if (accepted != result.rounds[r].end()) chosen = &*accepted;
  }
  return *chosen;
}

Grounds grounds_of(const SearchResult& result, double structure) {
  Grounds grounds;
  grounds.structure = structure;
  if (result.rounds.empty() || result.rounds[0].empty()) return grounds;
  const Candidate& single = result.rounds[0].front();
  grounds.likeliest = single.name();
  grounds.advantage = advantage(result, single);
  if (result.rounds.size() < 2 || result.rounds[1].empty()) return grounds;
  const Candidate& pair = result.rounds[1].front();
  if (!pair.exact.solved && !result.compares_fast) return grounds;
  grounds.likeliest_pair = pair.name();
  grounds.pair_gain = gain(result, pair, single);
  return grounds;
}

using Weights = std::vector<std::pair<const Candidate*, double>>;

// Candidates that were looked at as closely as the chosen one, and how probable each is of them. An effect has the odds
// against it that it takes to be accepted: nulls have some advantage, too.
Weights weigh(const SearchResult& result, const Candidate& chosen) {
  Weights weights{{&result.numbers, 0.0}};
  for (std::size_t r = 0; r < result.rounds.size(); ++r)
    for (const Candidate& candidate : result.rounds[r]) {
      const bool is_compared = result.compares_fast || candidate.exact.solved || !chosen.exact.solved;
      const Candidate& without = r == 0 ? result.numbers : result.rounds[r - 1].front();
      double odds = 0.0;
      for (std::size_t k = 0; k < candidate.kinds.size(); ++k) odds += least_gain(result, k);
      if (candidate.best().solved && is_compared && matters(result, candidate, without))
        weights.emplace_back(&candidate, advantage(result, candidate) - odds);
    }
  double best = 0.0, all = 0.0;
  for (const auto& weight : weights) best = std::max(best, weight.second);
  for (auto& weight : weights) all += weight.second = std::exp((weight.second - best) / kTemperature);
  for (auto& weight : weights) weight.second /= all;
  return weights;
}

double probability_of(const std::string& kind, const Weights& weights) {
  double with = 0.0;
  for (const auto& [candidate, weight] : weights)
    if (std::find(candidate->kinds.begin(), candidate->kinds.end(), kind) != candidate->kinds.end()) with += weight;
  // Nobody who has seen some dozens of cases may be surer.
  return std::clamp(with, 1.0 - kSurest, kSurest);
}

bool has_markers(const std::vector<RecordedTrial>& trials, const Channels& channels) {
  return std::any_of(trials.begin(), trials.end(), [&](const RecordedTrial& trial) {
    return trial.seen.leftCols(3 * channels.markers).array().isFinite().any();
  });
}

void show_held_out(const RecordedSession& session, const SearchResult& result, const Candidate& chosen,
                   const std::array<Eigen::VectorXd, 3>& offsets, int threads, Diagnosis& diagnosis) {
  const Channels channels = channels_of(session.scene);
  diagnosis.held_out_seen = has_markers(session.held_out, channels);
  if (!diagnosis.held_out_seen) {
    if (!session.held_out.empty())
      diagnosis.remarks.emplace_back("The held-out recordings hold pad poses alone: there is nothing to compare with.");
    return;
  }
  Candidate assumed;
  assumed.hypothesis.numbers = false;
  ModelResiduals residuals;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(channels.count());
  const std::array<const Candidate*, 3> models{&assumed, &result.numbers, &chosen};
  const std::array<std::vector<RowMatrix>*, 3> of_model{&residuals.assumed, &residuals.parameters,
                                                        &residuals.explained};
  const std::size_t trials = session.held_out.size();
  for (std::vector<RowMatrix>* of : of_model) of->resize(trials);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
  for (std::size_t i = 0; i < models.size() * trials; ++i) {
    const RecordedTrial& trial = session.held_out[i / models.size()];
    const std::size_t model = i % models.size();
    RowMatrix& residual = (*of_model[model])[i / models.size()];
    try {
      residual = trial.seen - predict(session.scene, trial, *models[model], none);
    } catch (const ModelError& error) {
      residual = RowMatrix::Constant(trial.seen.rows(), trial.seen.cols(), std::numeric_limits<double>::quiet_NaN());
#pragma omp critical
      diagnosis.remarks.push_back("The held-out recordings are not compared where " + models[model]->name() +
                                  " predicts nothing: " + error.what() + ".");
    }
  }
  Comparison held_out = compare(session.scene, session.held_out, residuals, offsets);
  diagnosis.held_out = held_out.misfits;
  for (TrialCourse& course : held_out.courses) {
    course.held_out = true;
    diagnosis.courses.push_back(std::move(course));
  }
}

// All that is likely enough but what was found.
void name_alternatives(const Weights& weights, const Candidate* found, Diagnosis& diagnosis) {
  for (const auto& [candidate, weight] : weights)
    if (candidate != found && weight > kSaid)
      diagnosis.alternatives.push_back({candidate->name(), weight, candidate->best().chi_square});
  std::sort(diagnosis.alternatives.begin(), diagnosis.alternatives.end(),
            [](const Alternative& a, const Alternative& b) { return a.probability > b.probability; });
}

// Something without a name. map: becomes that of a force or pressure, where one would explain the markers.
Finding unknown_of(const SearchResult& result, const Candidate& chosen, double probability, MismatchMap& map) {
  Finding unknown;
  unknown.kind = "unknown";
  unknown.title = title_of("unknown");
  unknown.summary = result.complete
                        ? "None of the effects that this tool knows brings the markers' misfit down to noise."
                        : "The markers do not fit, and the search was stopped before an explanation was found.";
  unknown.probability = probability;
  if (MismatchMap disturbed = disturbance_map(result.exact, result.numbers.best()); !disturbed.of_tet.empty())
    map = std::move(disturbed);
  if (!map.of_tet.empty()) unknown.where = Finding::Place{map.peak, map.radius};
  set_when_left(result.exact, chosen.best(), unknown);
  return unknown;
}

void judge(const SearchResult& result, const Candidate& chosen, const RecordedSession& session, Diagnosis& diagnosis) {
  const Scene& scene = session.scene;
  const Channels channels = channels_of(scene);
  const std::array<double, 3> left = structure_left(result.exact.errors, channels, pointers_to(chosen.best().residuals),
                                                    session.is_dynamic() ? 1 : 15);
  diagnosis.grounds = grounds_of(result, left[0]);
  const bool unexplained = left[0] > kStructure;
  const double unknown_probability =
      unexplained ? std::min(kSurest, logistic((left[0] - kStructure) / (0.2 * kStructure))) : 0.0;
  Weights weights = weigh(result, chosen);
  for (auto& weight : weights) weight.second *= 1.0 - unknown_probability;
  for (const std::string& kind : chosen.kinds) {
    Finding finding = finding_of(kind, chosen.best(), scene);
    finding.probability = probability_of(kind, weights);
    set_when(result.exact, result.numbers.best(), chosen.best(), finding);
    diagnosis.findings.push_back(std::move(finding));
  }
  const bool measurement = !chosen.kinds.empty() && std::all_of(chosen.kinds.begin(), chosen.kinds.end(),
                                                                [](const auto& k) { return kMeasurement.contains(k); });
  diagnosis.verdict = chosen.kinds.empty() ? Verdict::no_mismatch
                      : measurement        ? Verdict::measurement
                                           : Verdict::missing_physics;
  MismatchMap map = mismatch_map(result, scene);
  if (unexplained) {
    // What was named does not explain it: it is an alternative, not a finding.
    diagnosis.findings = {unknown_of(result, chosen, unknown_probability, map)};
    diagnosis.verdict = Verdict::unexplained;
  }
  if (numbers_differ(chosen.best(), scene)) {
    Finding numbers = finding_of("parameters", chosen.best(), scene);
    numbers.probability = 0.9;
    diagnosis.findings.push_back(numbers);
    if (diagnosis.verdict == Verdict::no_mismatch) diagnosis.verdict = Verdict::parameters;
  }
  if (diagnosis.verdict != Verdict::no_mismatch) diagnosis.mismatch_map = map.of_tet;
  name_alternatives(weights, unexplained ? nullptr : &chosen, diagnosis);
}

// A search that was stopped while markers do not fit has not shown that there is nothing, nor that nothing has a name.
void doubt(const SearchResult& result, const Candidate& chosen, const Scene& scene, Diagnosis& diagnosis) {
  constexpr double kMisfit = 1.3;  // of the noise
  constexpr double kEven = 0.5;
  const bool misfits = diagnosis.trials.explained.marker_mm > kMisfit * diagnosis.noise_marker_mm;
  if (!misfits && diagnosis.verdict != Verdict::unexplained && !has_unheard_rival(result, chosen)) return;
  for (Finding& finding : diagnosis.findings) finding.probability = std::min(finding.probability, kEven);
  if (diagnosis.verdict != Verdict::no_mismatch && diagnosis.verdict != Verdict::parameters) return;
  diagnosis.verdict = Verdict::unexplained;
  MismatchMap map = mismatch_map(result, scene);
  diagnosis.findings.push_back(unknown_of(result, chosen, kEven, map));
  diagnosis.mismatch_map = map.of_tet;
  for (Alternative& alternative : diagnosis.alternatives) alternative.probability *= 1.0 - kEven;
}

// What would tell the two likeliest explanations apart.
std::string next_experiment_of(const Diagnosis& diagnosis, const Candidate& chosen) {
  if (diagnosis.alternatives.empty() || diagnosis.verdict == Verdict::no_mismatch) return {};
  const std::string& rival = diagnosis.alternatives.front().kind;
  const std::string experiment = std::string(experiment_for(rival)) + ".";
  if (diagnosis.verdict == Verdict::unexplained) return "To see whether it is " + rival + " after all: " + experiment;
  return "To tell " + chosen.name() + " from " + rival + ": " + experiment;
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::no_mismatch:
      return "no-mismatch";
    case Verdict::parameters:
      return "parameters";
    case Verdict::measurement:
      return "measurement";
    case Verdict::missing_physics:
      return "missing-physics";
    case Verdict::unexplained:
      return "unexplained";
  }
  return "";
}
Diagnosis diagnose(const RecordedSession& session, const SearchOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const SearchResult result = search(session, options);
  Diagnosis diagnosis;
  diagnosis.bundle = session.scene.name;
  diagnosis.complete = result.complete;
  if (!result.complete) diagnosis.remarks.emplace_back("Stopped before its end: not all explanations were tried.");
  diagnosis.remarks.insert(diagnosis.remarks.end(), result.remarks.begin(), result.remarks.end());
  if (!result.assumed.solved)
    throw ModelError("the assumed physics has no equilibrium on the way: " + result.assumed.trouble);
  const Candidate& chosen = chosen_of(result);
  judge(result, chosen, session, diagnosis);
  diagnosis.noise_marker_mm = session.is_dynamic() ? error_model(session).noise[0] : result.exact.errors.noise[0];
  diagnosis.noise_force_N = session.force_noise;
  diagnosis.discretisation_marker_mm = result.discretisation_mm;
  const std::array<Eigen::VectorXd, 3> offsets{offset_of(result.exact, result.assumed),
                                               offset_of(result.exact, result.numbers.best()),
                                               offset_of(result.exact, chosen.best())};
  Comparison fitted = compare(
      session.scene, session.trials,
      {residuals_of(result.assumed), residuals_of(result.numbers.best()), residuals_of(chosen.best())}, offsets);
  diagnosis.trials = fitted.misfits;
  diagnosis.courses = std::move(fitted.courses);
  diagnosis.markers = std::move(fitted.markers);
  if (!result.complete) doubt(result, chosen, session.scene, diagnosis);
  show_held_out(session, result, chosen, offsets, options.threads > 0 ? options.threads : omp_get_num_procs(),
                diagnosis);
  diagnosis.next_experiment = next_experiment_of(diagnosis, chosen);
  diagnosis.explained = chosen;
  diagnosis.offset = offsets[2];
  diagnosis.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return diagnosis;
}

}  // namespace tissued::core
