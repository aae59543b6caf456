#include "tests/core/diagnosis/twin_session.hpp"

#include <random>

#include "core/diagnosis/path_solver.hpp"
#include "core/diagnosis/recorder.hpp"
#include "tests/core/test_bodies.hpp"

namespace tissued::core::testing {

namespace {

constexpr double kRate = 50.0;  // Hz
constexpr double kHold = 1.2, kRest = 0.4;

// Sum of twelve: near enough to a normal distribution, and the same on every platform.
double normal(std::mt19937& generator) {
  double sum = 0.0;
  for (int i = 0; i < 12; ++i) sum += 0.5 * symmetric_random(generator);
  return sum;
}

void record(const Scene& scene, const TwinTruth& truth, const RecordedSession& session, std::mt19937& generator,
            int index, RecordedTrial& trial) {
  std::vector<const Effect*> effects;
  for (const std::string& kind : truth.effects) effects.push_back(find_effect(kind));
  effects.insert(effects.end(), truth.others.begin(), truth.others.end());
  PathSolver solver(scene, effects);
  for (const auto& [name, value] : truth.numbers) solver.set_parameter(name, value);
  const LoadPath path(trial, scene, 1.0);
  PathAnswer answer;
  if (!solver.solve(path, 0, {}, answer)) throw ModelError(solver.trouble());
  MeasurementFaults faults;
  faults.latency = truth.latency;
  faults.rotation = truth.rotation;
  faults.shift = truth.shift;
  faults.slips = truth.slips;
  trial.seen = recorded(trial, index, path, scene, answer.values, faults);
  for (Eigen::Index f = 0; f < trial.seen.rows(); ++f)
    for (int c = 0; c < trial.seen.cols(); ++c) trial.seen(f, c) += session.noise_of(c) * normal(generator);
  const Channels channels = channels_of(scene);
  trial.seen.middleCols(3 * channels.markers, 3 * channels.targets)
      .setConstant(std::numeric_limits<double>::quiet_NaN());
  for (int pad = 0; pad < channels.pads; ++pad)
    if (trial.pads.front()[pad].kind == PadInput::Kind::absent)
      trial.seen.middleCols<3>(channels.of_force(pad)).setConstant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

RecordedTrial push_trial(const Scene& scene, const std::string& name, const std::vector<int>& pads, double depth,
                         double speed) {
  RecordedTrial trial;
  trial.name = name;
  const double ramp = depth / speed, total = 2.0 * ramp + kHold + kRest;
  for (int f = 0; f < static_cast<int>(total * kRate); ++f) {
    const double t = f / kRate;
    const double push = std::clamp(std::min(t, 2.0 * ramp + kHold - t) * speed, 0.0, depth);
    std::vector<PadInput> inputs(scene.pads.size());
    for (int pad : pads) {
      inputs[pad].kind = PadInput::Kind::pose;
      inputs[pad].center = scene.pads[pad].center + push * scene.pads[pad].direction;
    }
    trial.time.push_back(t);
    trial.pads.push_back(inputs);
  }
  return trial;
}

RecordedSession twin_session(const TwinTruth& truth, unsigned seed) {
  RecordedSession session;
  session.scene = box_scene({5, 4, 3, 10.0}, 12);
  session.scene.rate = kRate;
  session.marker_noise = session.scene.marker_noise = truth.marker_noise;
  std::mt19937 generator(seed);
  session.trials = {push_trial(session.scene, "first", {0}, 6.0, 8.0),
                    push_trial(session.scene, "second", {1}, 5.0, 8.0),
                    push_trial(session.scene, "quick", {0}, 5.0, 25.0)};
  session.held_out = {push_trial(session.scene, "both", {0, 1}, 4.0, 8.0)};
  int index = 0;
  for (std::vector<RecordedTrial>* group : {&session.trials, &session.held_out})
    for (RecordedTrial& trial : *group) record(session.scene, truth, session, generator, index++, trial);
  return session;
}

}  // namespace tissued::core::testing
