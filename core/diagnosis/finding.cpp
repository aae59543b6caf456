#include "core/diagnosis/finding.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/diagnosis/words.hpp"

namespace tissued::core {

namespace {

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
    // To first order, through whatever `reported` does to the numbers.
    std::vector<Values> slopes(numbers.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::string name = model_parameter(*effect, effect->parameters()[k]);
      if (!fit.has(name)) continue;
      std::vector<double> shifted = values;
      const double step = 1e-4 * std::max(1e-3, fit.sd(name));
      shifted[k] += step;
      const std::vector<EffectNumber> after = effect->reported(shifted);
      for (std::size_t i = 0; i < numbers.size(); ++i)
        slopes[i].emplace_back(name, (after[i].value - numbers[i].value) / step);
    }
    for (const Values& of_number : slopes) sds.push_back(fit.sd(of_number));
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

// What the frames of a trial are, an index of the phases in set_when.
int phase_of(const LoadPath& path, const RecordedTrial& trial, int frame) {
  if (const Motion* motion = path.motion()) {
    constexpr double kSwing = 1.0;  // s
    return trial.time[frame] < motion->release ? 0 : trial.time[frame] < motion->release + kSwing ? 4 : 5;
  }
  static constexpr double kStill = 1e-3, kUnloaded = 0.02;
  const double load = path.load(trial.time[frame]);
  const double before = path.load(trial.time[std::max(0, frame - 1)]);
  const double after = path.load(trial.time[std::min(trial.frame_count() - 1, frame + 1)]);
  if (after - before > kStill) return 1;
  if (before - after > kStill) return 3;
  return load < kUnloaded * path.peak_load() ? 0 : 2;
}

}  // namespace

Finding finding_of(const std::string& kind, const Fit& fit, const Scene& scene) {
  Finding finding;
  finding.kind = kind;
  finding.title = title_of(kind);
  finding.summary = summary_of(kind, fit, scene);
  finding.where = place_of(kind, fit, scene);
  finding.parameters = numbers_of(kind, fit, scene);
  return finding;
}

namespace {

// of_sample(trial, frame, channel): what counts, in units of the noise squared; not finite where there is nothing.
template <typename OfFrame>
void set_when(const FitData& data, const OfFrame& of_sample, Finding& finding) {
  static const std::array<const char*, 6> kPhases{"rest", "push", "hold", "release", "swing", "settled"};
  std::array<double, 6> gain{}, frames{};
  std::vector<double> of_trial;
  const RecordedSession& session = *data.session;
  for (std::size_t k = 0; k < session.trials.size(); ++k) {
    double sum = 0.0;
    for (int f = 0; f < session.trials[k].frame_count(); ++f) {
      double of_frame = 0.0;
      for (int c = 0; c < channels_of(session.scene).count(); ++c) {
        const double sample = of_sample(k, f, c) / std::pow(data.errors.noise[c], 2);
        if (std::isfinite(sample)) of_frame += sample;
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

}  // namespace

void set_when(const FitData& data, const Fit& before, const Fit& after, Finding& finding) {
  const Nuisances was = nuisances(data.errors, pointers_to(before.residuals)),
                  is = nuisances(data.errors, pointers_to(after.residuals));
  set_when(
      data,
      [&](std::size_t k, int f, int c) {
        return std::pow(before.residuals[k].residual(f, c) - was.offset[c], 2) -
               std::pow(after.residuals[k].residual(f, c) - is.offset[c], 2);
      },
      finding);
}

void set_when_left(const FitData& data, const Fit& fit, Finding& finding) {
  const Nuisances off = nuisances(data.errors, pointers_to(fit.residuals));
  set_when(
      data, [&](std::size_t k, int f, int c) { return std::pow(fit.residuals[k].residual(f, c) - off.offset[c], 2); },
      finding);
}

MismatchMap mismatch_map(const SearchResult& result, const Scene& scene) {
  MismatchMap map;
  if (result.rounds.empty()) return map;
  for (const Candidate& candidate : result.rounds[0]) {
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

}  // namespace tissued::core
