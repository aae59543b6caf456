#include "core/diagnosis/diagnosis.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/choice.hpp"
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

// The explanation leaves most of what the markers misfit by, beyond noise, with the right numbers alone.
bool leaves_most(const Misfits& misfits, double noise_mm) {
  constexpr double kMost = 0.5;
  const auto beyond_noise = [&](const Misfit& misfit) { return std::pow(misfit.marker_mm, 2) - std::pow(noise_mm, 2); };
  return beyond_noise(misfits.explained) > kMost * beyond_noise(misfits.parameters);
}

// diagnosis: its trials and noise are known.
void judge(const SearchResult& result, const Candidate& chosen, const RecordedSession& session, Diagnosis& diagnosis) {
  constexpr double kMisfit = 1.3;  // of the noise
  constexpr double kEven = 0.5;    // the most that is said of a search that was stopped and left something
  const Scene& scene = session.scene;
  const Channels channels = channels_of(scene);
  const std::array<double, 3> left = structure_left(result.exact.errors, channels, pointers_to(chosen.best().residuals),
                                                    session.is_dynamic() ? 1 : 15);
  diagnosis.grounds = grounds_of(result, left[0]);
  // A search that was stopped while markers do not fit has not shown that there is nothing, nor that what little it
  // found is it.
  const bool misfits = diagnosis.trials.explained.marker_mm > kMisfit * diagnosis.noise_marker_mm;
  const bool untried = !result.complete && misfits && leaves_most(diagnosis.trials, diagnosis.noise_marker_mm);
  const bool unexplained = left[0] > kStructure || untried;
  const bool doubted = !result.complete && (misfits || unexplained || has_unheard_rival(result, chosen));
  const double surest = doubted ? kEven : kSurest;
  const double unknown_probability = untried ? kEven
                                     : unexplained
                                         ? std::min(surest, logistic((left[0] - kStructure) / (0.2 * kStructure)))
                                         : 0.0;
  Weights weights = weigh(result, chosen);
  for (auto& weight : weights) weight.second *= 1.0 - unknown_probability;
  for (const std::string& kind : chosen.kinds) {
    Finding finding = finding_of(kind, chosen.best(), scene);
    finding.probability = std::min(surest, probability_of(kind, weights));
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
    numbers.probability = std::min(surest, 0.9);
    diagnosis.findings.push_back(numbers);
    if (diagnosis.verdict == Verdict::no_mismatch) diagnosis.verdict = Verdict::parameters;
  }
  if (diagnosis.verdict != Verdict::no_mismatch) diagnosis.mismatch_map = map.of_tet;
  name_alternatives(weights, unexplained ? nullptr : &chosen, diagnosis);
}

// What would tell the two likeliest explanations apart.
std::string next_experiment_of(const Diagnosis& diagnosis, const Candidate& chosen) {
  const bool unexplained = diagnosis.verdict == Verdict::unexplained;
  const auto rival = std::find_if(diagnosis.alternatives.begin(), diagnosis.alternatives.end(),
                                  [&](const Alternative& a) { return !unexplained || a.kind != "parameters"; });
  if (rival == diagnosis.alternatives.end() || diagnosis.verdict == Verdict::no_mismatch) return {};
  const std::string experiment =
      rival->kind + (unexplained ? " after all: " : ": ") + std::string(experiment_for(rival->kind)) + ".";
  return unexplained ? "To see whether it is " + experiment : "To tell " + chosen.name() + " from " + experiment;
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

Diagnosis conclude(const RecordedSession& session, const SearchResult& result, int threads) {
  if (!result.assumed.solved)
    throw ModelError("the assumed physics has no equilibrium on the way: " + result.assumed.trouble);
  Diagnosis diagnosis;
  diagnosis.bundle = session.scene.name;
  diagnosis.complete = result.complete;
  if (!result.complete) diagnosis.remarks.emplace_back("Stopped before its end: not all explanations were tried.");
  diagnosis.remarks.insert(diagnosis.remarks.end(), result.remarks.begin(), result.remarks.end());
  const Candidate& chosen = chosen_of(result);
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
  judge(result, chosen, session, diagnosis);
  show_held_out(session, result, chosen, offsets, threads, diagnosis);
  diagnosis.next_experiment = next_experiment_of(diagnosis, chosen);
  diagnosis.explained = chosen;
  diagnosis.offset = offsets[2];
  return diagnosis;
}

Diagnosis diagnose(const RecordedSession& session, const SearchOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Diagnosis diagnosis =
      conclude(session, search(session, options), options.threads > 0 ? options.threads : omp_get_num_procs());
  diagnosis.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return diagnosis;
}

}  // namespace tissued::core
