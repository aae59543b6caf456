#include "core/diagnosis/candidate.hpp"

#include <algorithm>

namespace tissued::core {

namespace {

Candidate effect_candidate(const Effect& effect, const Scene& scene) {
  Candidate candidate;
  candidate.kinds = {std::string(effect.kind())};
  candidate.hypothesis.effects = {&effect};
  for (const std::vector<double>& start : effect.starts(scene)) {
    Values values;
    for (std::size_t k = 0; k < start.size(); ++k)
      values.emplace_back(model_parameter(effect, effect.parameters()[k]), start[k]);
    candidate.starts.push_back(std::move(values));
  }
  for (std::size_t k = 0; k < effect.parameters().size(); ++k)
    if (effect.parameters()[k].fixed) candidate.hypothesis.fixed.push_back(candidate.starts.front()[k]);
  return candidate;
}

// Where one marker's residual has a step that stays, in the trials one after the other.
struct Step {
  SlippedMarker slip;
  double gain = 0.0;  // of chi square
};

// Means of the residual before and after every frame, by running sums; markers one at a time.
Step largest_step(const Fit& fit, const RecordedSession& session, int marker, double noise) {
  const Channels channels = channels_of(session.scene);
  struct Sample {
    int trial;
    double time;
    Vec3 residual;
  };
  std::vector<Sample> samples;
  for (std::size_t k = 0; k < fit.residuals.size(); ++k)
    for (Eigen::Index f = 0; f < fit.residuals[k].residual.rows(); ++f) {
      const Vec3 residual = fit.residuals[k].residual.row(f).segment<3>(channels.of_marker(marker)).transpose();
      if (residual.allFinite()) samples.push_back({static_cast<int>(k), session.trials[k].time[f], residual});
    }
  Step best;
  Vec3 total = Vec3::Zero(), before = Vec3::Zero();
  for (const Sample& sample : samples) total += sample.residual;
  const auto count = static_cast<double>(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto first = static_cast<double>(i), second = count - first;
    if (first >= 5.0 && second >= 5.0) {
      const Vec3 shift = (total - before) / second - before / first;
      const double gain = shift.squaredNorm() * first * second / count / (noise * noise);
      if (gain > best.gain) best = {{marker, samples[i].trial, samples[i].time, shift}, gain};
    }
    before += samples[i].residual;
  }
  return best;
}

std::vector<SlippedMarker> slipped_markers(const RecordedSession& session, const FitData& data, const Fit& numbers) {
  constexpr double kLeastShift = 0.4;  // mm
  constexpr double kLeastGain = 100.0;
  constexpr std::size_t kMost = 3;
  std::vector<Step> steps;
  for (int i = 0; i < static_cast<int>(session.scene.markers.size()); ++i) {
    const Step step = largest_step(numbers, session, i, data.errors.noise[3 * i]);
    if (step.gain > kLeastGain && step.slip.shift.norm() > kLeastShift) steps.push_back(step);
  }
  std::sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.gain > b.gain; });
  if (steps.size() > kMost) steps.resize(kMost);
  std::vector<SlippedMarker> slips;
  for (const Step& step : steps) slips.push_back(step.slip);
  return slips;
}

// Those of an effect with many starts that are far from each other, of which so many are kept.
void thin_out(std::vector<Values>& starts, std::size_t most) {
  if (starts.size() <= most) return;
  for (std::size_t i = 0; i < most; ++i) starts[i] = starts[i * starts.size() / most];
  starts.resize(most);
}

// The load of the largest force in any trial; nullptr: none.
const EdgeLoad* largest_load(const RecordedSession& session) {
  const EdgeLoad* largest = nullptr;
  for (const RecordedTrial& trial : session.trials)
    for (const EdgeLoad& load : trial.motion->loads)
      if (largest == nullptr || load.force.norm() > largest->force.norm()) largest = &load;
  return largest;
}

// What a load weighs is known; what it resists being moved with is likely, but not sure, to be the mass of that weight.
void set_load(const EdgeLoad& load, Candidate& mass) {
  const Vec3 middle = 0.5 * (load.edge[0] + load.edge[1]);
  Values& start = mass.starts.front();
  mass.starts.resize(1);
  mass.hypothesis.fixed.clear();
  for (auto& [name, value] : start) {
    if (name == "attached-mass.mass") {
      value = kMillinewtonPerNewton * load.force.norm() / kStandardGravity / kKilogramPerGram;
      continue;
    }
    value = name == "attached-mass.load" ? load.force.norm() : middle[name.back() - 'x'];
    mass.hypothesis.fixed.emplace_back(name, value);
  }
}

}  // namespace

std::string Candidate::name() const {
  std::string text;
  for (const std::string& kind : kinds) text += (text.empty() ? "" : " + ") + kind;
  return text.empty() ? "parameters" : text;
}

Candidate numbers_candidate() {
  Candidate candidate;
  candidate.starts = {{}};
  return candidate;
}

std::vector<Candidate> motion_candidates(const RecordedSession& session) {
  constexpr std::size_t kMostStarts = 3;
  const EdgeLoad* load = largest_load(session);
  std::vector<Candidate> candidates;
  for (const Effect* effect : effects()) {
    if (effect->kind() == "parameters" || (effect->kind() == "sliding-actuator" && session.scene.pads.empty()))
      continue;
    candidates.push_back(effect_candidate(*effect, session.scene));
    thin_out(candidates.back().starts, kMostStarts);
    if (effect->kind() == "attached-mass" && load != nullptr) set_load(*load, candidates.back());
  }
  for (Candidate& candidate : candidates) candidate.hypothesis.releases = static_cast<int>(session.trials.size());
  return candidates;
}

std::vector<Candidate> single_candidates(const RecordedSession& session, const FitData& data, const Fit& numbers) {
  std::vector<Candidate> candidates;
  for (const Effect* effect : effects())
    if (effect->kind() != "parameters" && !effect->is_dynamic())
      candidates.push_back(effect_candidate(*effect, session.scene));
  Candidate latency = numbers_candidate(), registration = numbers_candidate(), slip = numbers_candidate();
  latency.kinds = {"latency"};
  latency.hypothesis.latency = true;
  candidates.push_back(std::move(latency));
  registration.kinds = {"registration"};
  registration.hypothesis.registration = true;
  candidates.push_back(std::move(registration));
  slip.kinds = {"marker-slip"};
  slip.hypothesis.slips = slipped_markers(session, data, numbers);
  if (!slip.hypothesis.slips.empty()) {
    for (const SlippedMarker& marker : slip.hypothesis.slips)
      for (int axis = 0; axis < 3; ++axis)
        slip.starts.front().emplace_back("marker-slip." + session.scene.markers[marker.marker].name + "." + "xyz"[axis],
                                         marker.shift[axis]);
    candidates.push_back(std::move(slip));
  }
  return candidates;
}

Candidate extended(const Candidate& first, const Candidate& second) {
  Candidate pair = first;
  pair.fast = pair.exact = Fit();
  pair.promises.clear();
  pair.kinds.insert(pair.kinds.end(), second.kinds.begin(), second.kinds.end());
  Hypothesis& hypothesis = pair.hypothesis;
  hypothesis.effects.insert(hypothesis.effects.end(), second.hypothesis.effects.begin(),
                            second.hypothesis.effects.end());
  hypothesis.latency = hypothesis.latency || second.hypothesis.latency;
  hypothesis.registration = hypothesis.registration || second.hypothesis.registration;
  if (hypothesis.slips.empty()) hypothesis.slips = second.hypothesis.slips;
  hypothesis.fixed.insert(hypothesis.fixed.end(), second.hypothesis.fixed.begin(), second.hypothesis.fixed.end());
  pair.starts.clear();
  const Values base = values_of(first.best());
  for (Values start : second.starts) {
    Values values = base;
    values.insert(values.end(), start.begin(), start.end());
    pair.starts.push_back(std::move(values));
  }
  return pair;
}

Values values_of(const Fit& fit) {
  Values values;
  for (const Unknown& unknown : fit.unknowns)
    if (unknown.source != Unknown::Source::discretisation) values.emplace_back(unknown.name, unknown.value);
  return values;
}

}  // namespace tissued::core
