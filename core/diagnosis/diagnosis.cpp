#include "core/diagnosis/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/diagnosis/words.hpp"

namespace tissued::core {

namespace {

// What must be met before something is said; measured on nulls of our own (scripts/nulls).
constexpr double kAccept = 20.0;      // advantage over numbers alone, or of a pair over its better half
constexpr double kModulusOff = 0.12;  // of the logarithm of Young's modulus: what the elements may err
constexpr double kRatioOff = 0.015;   // of Poisson's ratio, likewise
constexpr double kStructure = 1.5;    // of markers' structure_left: beyond, something is left to explain
constexpr double kTemperature = 6.0;  // by which evidence is too sure of itself
constexpr double kSurest = 0.98;      // probability
constexpr double kSaid = 0.02;        // probability below which an alternative is not listed

const std::set<std::string> kMeasurement{"latency", "registration", "marker-slip"};

std::vector<const TrialResidual*> all_of(const std::vector<TrialResidual>& residuals) {
  std::vector<const TrialResidual*> out;
  for (const TrialResidual& residual : residuals) out.push_back(&residual);
  return out;
}

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }

bool numbers_differ(const Fit& fit, const Scene& scene) {
  if (!fit.solved || !fit.has("youngs_modulus")) return false;
  const double modulus = std::abs(std::log(fit.value("youngs_modulus") / scene.material.youngs_modulus));
  const double modulus_sd = fit.sd("youngs_modulus") / fit.value("youngs_modulus");
  const double ratio = std::abs(fit.value("poissons_ratio") - scene.material.poissons_ratio);
  return (modulus > kModulusOff && modulus > 3.0 * modulus_sd) ||
         (ratio > kRatioOff && ratio > 3.0 * fit.sd("poissons_ratio"));
}

// The candidate that is believed: numbers alone, one effect, or two.
const Candidate& chosen_of(const SearchResult& result) {
  if (result.singles.empty() || advantage(result, result.singles.front()) < kAccept) return result.numbers;
  const Candidate& single = result.singles.front();
  if (result.pairs.empty()) return single;
  const double gain = advantage(result, result.pairs.front()) - advantage(result, single);
  return result.pairs.front().exact.solved && gain > kAccept ? result.pairs.front() : single;
}

// Of a kind among the candidates that are as rich as the chosen one.
double probability_of(const std::string& kind, const SearchResult& result, const Candidate& chosen) {
  double with = 0.0, all = 0.0;
  const double best = advantage(result, chosen);
  const auto add = [&](const Candidate& candidate, double gain) {
    const double weight = std::exp((gain - best) / kTemperature);
    all += weight;
    if (std::find(candidate.kinds.begin(), candidate.kinds.end(), kind) != candidate.kinds.end()) with += weight;
  };
  add(result.numbers, 0.0);
  for (const std::vector<Candidate>* group : {&result.singles, &result.pairs})
    for (const Candidate& candidate : *group)
      if (candidate.exact.solved || !chosen.exact.solved) add(candidate, advantage(result, candidate));
  // Nobody who has seen some dozens of cases may be surer.
  return all > 0.0 ? std::clamp(with / all, 1.0 - kSurest, kSurest) : 0.0;
}

std::vector<FindingNumber> numbers_of(const std::string& kind, const Fit& fit, const Scene& scene) {
  const auto grouped = [](const std::vector<EffectNumber>& numbers, const std::vector<double>& sds) {
    std::vector<FindingNumber> out;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const std::size_t dot = numbers[k].name.rfind('.');
      const std::string name = dot == std::string::npos ? numbers[k].name : numbers[k].name.substr(0, dot);
      if (out.empty() || out.back().name != name) out.push_back({name, numbers[k].unit, {}, {}});
      out.back().value.push_back(numbers[k].value);
      out.back().sd.push_back(sds[k]);
    }
    return out;
  };
  std::vector<EffectNumber> numbers;
  std::vector<double> sds;
  if (const Effect* effect = find_effect(kind); effect != nullptr && kind != "parameters") {
    const std::vector<double> values = effect_values(*effect, fit, scene);
    numbers = effect->reported(values);
    sds.assign(numbers.size(), 0.0);
    // To first order, through whatever `reported` does to the numbers.
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::string name = model_parameter(*effect, effect->parameters()[k]);
      if (!fit.has(name)) continue;
      std::vector<double> shifted = values;
      const double step = 1e-4 * std::max(1e-3, fit.sd(name));
      shifted[k] += step;
      const std::vector<EffectNumber> after = effect->reported(shifted);
      for (std::size_t i = 0; i < numbers.size(); ++i)
        sds[i] = std::hypot(sds[i], (after[i].value - numbers[i].value) / step * fit.sd(name));
    }
    return grouped(numbers, sds);
  }
  const auto belongs = [&kind](const std::string& name) {
    return kind == "parameters" ? name == "youngs_modulus" || name == "poissons_ratio" : name.starts_with(kind + ".");
  };
  constexpr double kDegrees = 57.29577951308232;
  for (const Unknown& unknown : fit.unknowns) {
    if (!belongs(unknown.name)) continue;
    const std::string name = kind == "parameters" ? unknown.name : unknown.name.substr(kind.size() + 1);
    const double scale = unknown.unit == "rad" ? kDegrees : 1.0;
    numbers.push_back({name, unknown.unit == "rad" ? "deg" : unknown.unit, scale * unknown.value});
    sds.push_back(scale * fit.sd(unknown.name));
  }
  return grouped(numbers, sds);
}

std::optional<Finding::Place> place_of(const std::string& kind, const Fit& fit, const Scene& scene) {
  if (!fit.has(kind + ".center.x")) return std::nullopt;
  Finding::Place place{Vec3(fit.value(kind + ".center.x"), fit.value(kind + ".center.y"), 0.0), 0.0};
  const std::string z = kind + ".center.z";
  if (fit.has(z)) place.center.z() = fit.value(z);
  for (const auto& [name, value] : fit.hypothesis.fixed)
    if (name == z) place.center.z() = value;
  place.radius = fit.has(kind + ".radius") ? fit.value(kind + ".radius") : 0.1 * scene.mesh.rest.maxCoeff();
  return place;
}

// Nearest of the places that were tried for a lump, by how much each promised.
struct MismatchMap {
  std::vector<double> of_tet;  // 0 to 1
  Vec3 peak = Vec3::Zero();
  double radius = 0.0;
};

MismatchMap mismatch_map(const SearchResult& result, const Scene& scene) {
  MismatchMap map;
  for (const Candidate& candidate : result.singles) {
    if (candidate.kinds.front() != "inclusion" || candidate.promises.size() < 2) continue;
    const double best = candidate.promises.front().chi_square, worst = candidate.promises.back().chi_square;
    if (!(worst > best)) return map;
    std::vector<Vec3> places;
    std::vector<double> gains;
    for (const Promise& promise : candidate.promises) {
      const Values& start = candidate.starts[promise.start];
      places.emplace_back(start[0].second, start[1].second, start[2].second);
      gains.push_back((worst - promise.chi_square) / (worst - best));
    }
    map.peak = places.front();
    map.radius = candidate.starts.front()[3].second;
    for (const Tet& tet : scene.mesh.tets) {
      Vec3 middle = Vec3::Zero();
      for (int node : tet) middle += 0.25 * scene.mesh.node(node);
      double sum = 0.0, weights = 0.0;
      for (std::size_t i = 0; i < places.size(); ++i) {
        const double weight = std::exp(-(middle - places[i]).squaredNorm() / (2.0 * map.radius * map.radius));
        sum += weight * gains[i];
        weights += weight;
      }
      map.of_tet.push_back(weights > 0.0 ? sum / weights : 0.0);
    }
  }
  return map;
}

// What the frames of a trial are: 0 at rest, 1 push, 2 hold, 3 release.
int phase_of(const LoadPath& path, const RecordedTrial& trial, int frame) {
  static constexpr double kStill = 1e-3, kUnloaded = 0.02;
  const double load = path.load(trial.time[frame]);
  const double before = path.load(trial.time[std::max(0, frame - 1)]);
  const double after = path.load(trial.time[std::min(trial.frame_count() - 1, frame + 1)]);
  if (after - before > kStill) return 1;
  if (before - after > kStill) return 3;
  return load < kUnloaded * path.peak_load() ? 0 : 2;
}

// Trials in which the chosen model explains most of what the other does not, and the phase.
void when_of(const FitData& data, const Fit& before, const Fit& after, Finding& finding) {
  static const std::array<const char*, 4> kPhases{"rest", "push", "hold", "release"};
  std::array<double, 4> gain{}, frames{};
  std::vector<double> of_trial;
  const RecordedSession& session = *data.session;
  const auto a = all_of(before.residuals), b = all_of(after.residuals);
  const Nuisances off_before = nuisances(data.errors, a), off_after = nuisances(data.errors, b);
  for (std::size_t k = 0; k < session.trials.size(); ++k) {
    double sum = 0.0;
    for (int f = 0; f < session.trials[k].frame_count(); ++f) {
      double of_frame = 0.0;
      for (int c = 0; c < channels_of(session.scene).count(); ++c) {
        const double was = before.residuals[k].residual(f, c) - off_before.offset[c];
        const double is = after.residuals[k].residual(f, c) - off_after.offset[c];
        if (std::isfinite(was)) of_frame += (was * was - is * is) / std::pow(data.errors.noise[c], 2);
      }
      const int phase = phase_of(data.paths[k], session.trials[k], f);
      gain[phase] += of_frame;
      frames[phase] += 1.0;
      sum += of_frame;
    }
    of_trial.push_back(sum);
  }
  const double most = *std::max_element(of_trial.begin(), of_trial.end());
  for (std::size_t k = 0; k < of_trial.size(); ++k)
    if (of_trial[k] > 0.5 * most) finding.trials.push_back(session.trials[k].name);
  std::size_t best = 0;
  double total = 0.0;
  for (std::size_t p = 0; p < gain.size(); ++p) {
    gain[p] = frames[p] > 0.0 ? gain[p] / frames[p] : 0.0;
    total += std::max(0.0, gain[p]);
    if (gain[p] > gain[best]) best = p;
  }
  finding.phase = gain[best] > 0.5 * total ? kPhases[best] : "throughout";
}

Finding finding_of(const std::string& kind, const SearchResult& result, const Candidate& chosen, const Scene& scene) {
  const Fit& fit = chosen.best();
  Finding finding;
  finding.kind = kind;
  finding.title = title_of(kind);
  finding.summary = summary_of(kind, fit, scene);
  finding.probability = probability_of(kind, result, chosen);
  finding.where = place_of(kind, fit, scene);
  finding.parameters = numbers_of(kind, fit, scene);
  when_of(result.exact, result.numbers.best(), fit, finding);
  return finding;
}

// Root mean squares over frames x channels of a kind, where markers sit taken off.
Misfit misfit_of(const std::vector<RowMatrix>& residuals, const Channels& channels, const Eigen::VectorXd& offset) {
  std::array<double, 3> square{}, count{};
  for (const RowMatrix& residual : residuals)
    for (Eigen::Index f = 0; f < residual.rows(); ++f)
      for (int c = 0; c < channels.count(); ++c) {
        if (!std::isfinite(residual(f, c))) continue;
        const int kind = channels.is_marker(c) ? 0 : channels.is_force(c) ? 2 : 1;
        square[kind] += std::pow(residual(f, c) - offset[c], 2);
        count[kind] += 1.0;
      }
  const auto rms = [&](int kind) {
    return count[kind] > 0.0 ? std::sqrt(square[kind] / count[kind]) : std::numeric_limits<double>::quiet_NaN();
  };
  return {rms(0), rms(1), rms(2)};
}

std::vector<RowMatrix> residuals_of(const Fit& fit) {
  std::vector<RowMatrix> out;
  for (const TrialResidual& trial : fit.residuals) out.push_back(trial.residual);
  return out;
}

Eigen::VectorXd offset_of(const FitData& data, const Fit& fit) {
  return nuisances(data.errors, all_of(fit.residuals)).offset;
}

// Where the three models differ from what was seen, on one set of trials.
struct Compared {
  const std::vector<RecordedTrial>* trials;
  std::vector<RowMatrix> assumed, parameters, explained;  // (trials) residuals
};

void describe(const Compared& compared, const RecordedSession& session, const std::array<Eigen::VectorXd, 3>& offsets,
              bool held_out, Diagnosis& diagnosis) {
  const Channels channels = channels_of(session.scene);
  Misfits& misfits = held_out ? diagnosis.held_out : diagnosis.trials;
  misfits = {misfit_of(compared.assumed, channels, offsets[0]), misfit_of(compared.parameters, channels, offsets[1]),
             misfit_of(compared.explained, channels, offsets[2])};
  for (std::size_t k = 0; k < compared.trials->size(); ++k) {
    const RecordedTrial& trial = (*compared.trials)[k];
    const LoadPath path(trial, session.scene, 2.0);
    TrialCourse course;
    course.name = trial.name;
    course.held_out = held_out;
    course.time = trial.time;
    for (double time : trial.time) course.load.push_back(path.load(time));
    const auto of_frames = [&](const RowMatrix& residual, const Eigen::VectorXd& offset) {
      std::vector<double> out;
      for (Eigen::Index f = 0; f < residual.rows(); ++f)
        out.push_back(misfit_of({residual.row(f)}, channels, offset).marker_mm);
      return out;
    };
    course.assumed_mm = of_frames(compared.assumed[k], offsets[0]);
    course.parameters_mm = of_frames(compared.parameters[k], offsets[1]);
    course.explained_mm = of_frames(compared.explained[k], offsets[2]);
    bool has_force = false;
    for (Eigen::Index f = 0; f < trial.seen.rows(); ++f) {
      double seen = 0.0, assumed = 0.0, explained = 0.0;
      for (int pad = 0; pad < channels.pads; ++pad) {
        const auto at = channels.of_force(pad);
        const Eigen::RowVector3d force = trial.seen.row(f).segment<3>(at);
        if (!force.allFinite()) continue;
        has_force = true;
        if (force.norm() < seen) continue;
        seen = force.norm();
        assumed = (force - compared.assumed[k].row(f).segment<3>(at)).norm();
        explained = (force - compared.explained[k].row(f).segment<3>(at)).norm();
      }
      course.force_seen_N.push_back(seen);
      course.force_assumed_N.push_back(assumed);
      course.force_explained_N.push_back(explained);
    }
    if (!has_force) {
      course.force_seen_N.clear();
      course.force_assumed_N.clear();
      course.force_explained_N.clear();
    }
    diagnosis.courses.push_back(std::move(course));
    if (held_out) continue;
    const auto peak = static_cast<Eigen::Index>(
        std::max_element(diagnosis.courses.back().load.begin(), diagnosis.courses.back().load.end()) -
        diagnosis.courses.back().load.begin());
    for (int i = 0; i < channels.markers; ++i) {
      const auto at = [&](const RowMatrix& from, const Eigen::VectorXd& offset) -> Vec3 {
        return (from.row(peak).segment<3>(3 * i).transpose() - offset.segment<3>(3 * i)).eval();
      };
      const Vec3 seen = at(trial.seen, offsets[2]);
      if (!seen.allFinite()) continue;
      diagnosis.markers.push_back({trial.name, session.scene.markers[i].name, session.scene.markers[i].rest, seen,
                                   seen - at(compared.assumed[k], offsets[2]),
                                   seen - at(compared.explained[k], offsets[2])});
    }
  }
}

bool has_markers(const std::vector<RecordedTrial>& trials, const Channels& channels) {
  return std::any_of(trials.begin(), trials.end(), [&](const RecordedTrial& trial) {
    return trial.seen.leftCols(3 * channels.markers).array().isFinite().any();
  });
}

void show_held_out(const RecordedSession& session, const SearchResult& result, const Candidate& chosen,
                   const std::array<Eigen::VectorXd, 3>& offsets, Diagnosis& diagnosis) {
  const Channels channels = channels_of(session.scene);
  diagnosis.held_out_seen = has_markers(session.held_out, channels);
  if (!diagnosis.held_out_seen) {
    if (!session.held_out.empty())
      diagnosis.remarks.emplace_back("The held-out recordings hold pad poses alone: there is nothing to compare with.");
    return;
  }
  Candidate assumed;
  assumed.hypothesis.numbers = false;
  Compared compared{&session.held_out, {}, {}, {}};
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(channels.count());
  for (const RecordedTrial& trial : session.held_out) {
    compared.assumed.push_back(trial.seen - predict(session.scene, trial, assumed, none));
    compared.parameters.push_back(trial.seen - predict(session.scene, trial, result.numbers, none));
    compared.explained.push_back(trial.seen - predict(session.scene, trial, chosen, none));
  }
  describe(compared, session, offsets, true, diagnosis);
}

void name_alternatives(const SearchResult& result, const Candidate& chosen, Diagnosis& diagnosis) {
  const double best = std::max(0.0, advantage(result, chosen));
  double all = 0.0;
  std::vector<std::pair<const Candidate*, double>> weights;
  const auto add = [&](const Candidate& candidate, double gain) {
    if (!candidate.best().solved) return;
    weights.emplace_back(&candidate, std::exp((gain - best) / kTemperature));
    all += weights.back().second;
  };
  add(result.numbers, 0.0);
  for (const std::vector<Candidate>* group : {&result.singles, &result.pairs})
    for (const Candidate& candidate : *group)
      if (candidate.exact.solved || !chosen.exact.solved) add(candidate, advantage(result, candidate));
  for (const auto& [candidate, weight] : weights)
    if (candidate != &chosen && weight / all > kSaid)
      diagnosis.alternatives.push_back({candidate->name(), weight / all, candidate->best().chi_square});
  std::sort(diagnosis.alternatives.begin(), diagnosis.alternatives.end(),
            [](const Alternative& a, const Alternative& b) { return a.probability > b.probability; });
}

void judge(const SearchResult& result, const Candidate& chosen, const RecordedSession& session, Diagnosis& diagnosis) {
  const Scene& scene = session.scene;
  const Channels channels = channels_of(scene);
  const std::array<double, 3> left = structure_left(result.exact.errors, channels, all_of(chosen.best().residuals));
  const bool unexplained = left[0] > kStructure;
  for (const std::string& kind : chosen.kinds) diagnosis.findings.push_back(finding_of(kind, result, chosen, scene));
  const bool measurement = !chosen.kinds.empty() && std::all_of(chosen.kinds.begin(), chosen.kinds.end(),
                                                                [](const auto& k) { return kMeasurement.contains(k); });
  diagnosis.verdict = chosen.kinds.empty() ? Verdict::no_mismatch
                      : measurement        ? Verdict::measurement
                                           : Verdict::missing_physics;
  const MismatchMap map = mismatch_map(result, scene);
  if (unexplained) {
    diagnosis.verdict = Verdict::unexplained;
    Finding unknown;
    unknown.kind = "unknown";
    unknown.title = title_of("unknown");
    unknown.summary = "None of the effects that this tool knows brings the markers' misfit down to noise.";
    unknown.probability = logistic((left[0] - kStructure) / (0.2 * kStructure));
    if (!map.of_tet.empty()) unknown.where = Finding::Place{map.peak, map.radius};
    when_of(result.exact, result.assumed, result.numbers.best(), unknown);
    // What was named does not explain it: it is an alternative, not a finding.
    for (const Finding& finding : diagnosis.findings)
      diagnosis.alternatives.push_back({finding.kind, 1.0 - unknown.probability, chosen.best().chi_square});
    diagnosis.findings = {unknown};
  }
  if (numbers_differ(chosen.best(), scene)) {
    Finding numbers = finding_of("parameters", result, chosen, scene);
    numbers.probability = 0.9;
    numbers.trials.clear();
    numbers.phase.clear();
    diagnosis.findings.push_back(numbers);
    if (diagnosis.verdict == Verdict::no_mismatch) diagnosis.verdict = Verdict::parameters;
  }
  if (diagnosis.verdict != Verdict::no_mismatch) diagnosis.mismatch_map = map.of_tet;
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

RowMatrix predict(const Scene& scene, const RecordedTrial& trial, const Candidate& model,
                  const Eigen::VectorXd& offset) {
  PathSolver solver(scene, model.hypothesis.effects);
  for (const auto& [name, value] : model.hypothesis.fixed) solver.set_parameter(name, value);
  MeasurementFaults faults;
  faults.slips = model.hypothesis.slips;
  for (const Unknown& unknown : model.best().unknowns) {
    if (unknown.source == Unknown::Source::body) solver.set_parameter(unknown.name, unknown.value);
    if (unknown.source == Unknown::Source::fault) fault_number(faults, unknown.fault) = unknown.value;
  }
  constexpr double kTravel = 2.0;
  const LoadPath path(trial, scene, kTravel);
  PathAnswer answer;
  if (!solver.solve(path, 0, {}, answer)) throw ModelError(trial.name + ": " + solver.trouble());
  // Markers that slipped did so before a trial that is predicted.
  constexpr int kAfterAll = std::numeric_limits<int>::max();
  RowMatrix out = recorded(trial, kAfterAll, path, scene, answer.values, faults);
  out.rowwise() += offset.transpose();
  return out;
}

Diagnosis diagnose(const RecordedSession& session, const SearchOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const SearchResult result = search(session, options);
  Diagnosis diagnosis;
  diagnosis.bundle = session.scene.name;
  diagnosis.complete = result.complete;
  if (!result.complete) diagnosis.remarks.emplace_back("Stopped before its end: not all explanations were tried.");
  if (!result.assumed.solved)
    throw ModelError("the assumed physics has no equilibrium on the way: " + result.assumed.trouble);
  const Candidate& chosen = chosen_of(result);
  judge(result, chosen, session, diagnosis);
  name_alternatives(result, chosen, diagnosis);
  diagnosis.noise_marker_mm = result.exact.errors.noise[0];
  diagnosis.noise_force_N = session.force_noise;
  diagnosis.discretisation_marker_mm = result.discretisation_mm;
  const std::array<Eigen::VectorXd, 3> offsets{offset_of(result.exact, result.assumed),
                                               offset_of(result.exact, result.numbers.best()),
                                               offset_of(result.exact, chosen.best())};
  describe(
      {&session.trials, residuals_of(result.assumed), residuals_of(result.numbers.best()), residuals_of(chosen.best())},
      session, offsets, false, diagnosis);
  show_held_out(session, result, chosen, offsets, diagnosis);
  if (!diagnosis.alternatives.empty() && diagnosis.verdict != Verdict::no_mismatch)
    diagnosis.next_experiment = "To tell " + chosen.name() + " from " + diagnosis.alternatives.front().kind + ": " +
                                std::string(experiment_for(diagnosis.alternatives.front().kind)) + ".";
  diagnosis.explained = chosen;
  diagnosis.offset = offsets[2];
  diagnosis.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return diagnosis;
}

}  // namespace tissued::core
