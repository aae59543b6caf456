#include "tests/study/alarm_session.hpp"

#include <algorithm>

#include "core/admm_simulator.hpp"
#include "core/diagnosis/path_solver.hpp"
#include "core/refined_mesh.hpp"
#include "tests/study/body.hpp"
#include "tests/study/random_scene.hpp"

namespace tissued::study {

namespace {

using core::Vec3;

constexpr double kRate = 50.0;    // Hz
constexpr double kOpening = 2.0;  // s at rest, before anything
constexpr double kTravel = 3.0;   // mm between the loads at which a twin is solved

protocol::Name name_of(const std::string& text) { return protocol::Name::from(text).value(); }
std::array<double, 3> array_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

config::DaemonConfig config_for(const core::Scene& scene) {
  config::DaemonConfig config;
  config.bundle.scene = scene;
  config.simulator.solver.time_step = 1.0 / scene.rate;
  config.simulator.solver.threads = 1;
  config.simulator.alarm.enabled = true;
  return config;
}

Course random_course(const Push& push, Random& random) {
  const double deepest = *std::max_element(push.depths.begin(), push.depths.end());
  Course course;
  course.share = random.uniform(0.3, 1.0);
  course.ramp = course.share * deepest / random.logarithmic(3.0, 30.0);
  course.hold = random.uniform(0.3, 6.0);
  course.rest = random.uniform(0.5, 5.0);
  return course;
}

std::vector<Vec3> marker_rests(const core::Scene& scene) {
  std::vector<Vec3> rests;
  for (const core::Marker& marker : scene.markers) rests.push_back(marker.rest);
  return rests;
}

// The assumed scene's way through so many seconds of pushes.
core::RecordedTrial pushed_trial(const WatchedBody& body, double seconds, Random& random) {
  core::RecordedTrial trial;
  trial.name = "live";
  const auto add = [&](std::vector<core::PadInput> pads) {
    trial.time.push_back(trial.frame_count() / body.scene.rate);
    trial.pads.push_back(std::move(pads));
  };
  const std::vector<core::PadInput> none(body.scene.pads.size());
  const auto rest = [&](double duration) {
    for (double t = 0.0; t < duration; t += 1.0 / body.scene.rate) add(none);
  };
  rest(kOpening);
  for (std::size_t k = 0; trial.time.back() < seconds; ++k) {
    const Push& push = body.pushes[k % body.pushes.size()];
    Course course = random_course(push, random);
    course.share = std::max(course.share, 0.6);
    for (double t = 0.0; t <= course.back(); t += 1.0 / body.scene.rate)
      add(pads_at(body.scene, push, course.share_at(t)));
    rest(course.rest);
  }
  return trial;
}

}  // namespace

WatchedBody draw_body(Random& random) {
  for (;;) try {
      WatchedBody body;
      Body drawn = random_body(random);
      body.shape = drawn.shape;
      body.scene.mesh = std::move(drawn.mesh);
      body.scene.rate = kRate;
      add_pads(body.scene, random);
      if (body.scene.pads.empty()) continue;
      body.scene.material.youngs_modulus = random.logarithmic(2.0, 20.0);
      body.scene.material.poissons_ratio = random.uniform(0.41, 0.48);
      body.truth = body.scene;
      body.truth.mesh = core::refined(body.scene.mesh);
      body.truth.material.youngs_modulus *= random.uniform(0.95, 1.05);
      body.truth.material.poissons_ratio += random.uniform(-0.01, 0.01);
      add_points(random.uniform(0.3, 0.5), random, body.scene, body.truth);
      body.pushes = random_pushes(body.scene, random);
      core::make_simulator(body.scene, config_for(body.scene).simulator);
      return body;
    } catch (const core::ModelError&) {
      // No model can be made of it: a marker too far from the skin, an element turned inside out.
    }
}

std::optional<std::vector<PushCurve>> solve_pushes(const WatchedBody& body) {
  std::vector<PushCurve> curves;
  for (const Push& push : body.pushes) {
    std::optional<PushCurve> curve = PushCurve::solve(body.truth, push);
    if (!curve) return std::nullopt;
    curves.push_back(std::move(*curve));
  }
  return curves;
}

WatchedSession::WatchedSession(const core::Scene& scene, const Nuisance& nuisance, std::uint64_t seed)
    : nuisance_(nuisance), random_(seed), rate_(scene.rate), hidden_until_(scene.markers.size(), 0.0) {
  const config::DaemonConfig config = config_for(scene);
  simulator_ = core::make_simulator(scene, config.simulator);
  processor_ = std::make_unique<daemon::FrameProcessor>(*simulator_, config, counters_);
  processor_->rest_answer(answer_);
}

void WatchedSession::begin_disturbances() {
  const auto begins = [this](double rate) { return random_.chance(rate / rate_); };
  if (begins(nuisance_.occlusions)) {
    const int marker = random_.integer(0, static_cast<int>(hidden_until_.size()) - 1);
    hidden_until_[static_cast<std::size_t>(marker)] = time() + random_.uniform(0.2, 3.0);
  }
  if (begins(nuisance_.gaps)) gap_until_ = time() + random_.uniform(0.1, 2.0);
  if (begins(nuisance_.loud)) loud_until_ = time() + 2.0;
}

bool WatchedSession::is_lost(std::size_t marker) {
  return random_.chance(nuisance_.blink) || time() < hidden_until_[marker];
}

void WatchedSession::step(const std::vector<core::PadInput>& pads, const Eigen::RowVectorXd& displaced,
                          const std::vector<Vec3>& marker_rest) {
  frames_ += 1.0;
  begin_disturbances();
  if (time() < gap_until_) return;
  const core::Scene& scene = simulator_->scene();
  frame_ = protocol::TrackerFrame{};
  frame_.frame_number = static_cast<std::uint32_t>(frames_);
  frame_.stamp_ns = static_cast<std::uint64_t>(1e9 * time());
  frame_.receive_ns = *frame_.stamp_ns;
  for (std::size_t i = 0; i < pads.size(); ++i)
    if (pads[i].kind == core::PadInput::Kind::pose)
      frame_.objects.push_back({name_of(scene.pads[i].name), array_of(pads[i].center), {}});
  const double noise = nuisance_.noise * (time() < loud_until_ ? 4.0 : 1.0);
  const bool outlier = random_.chance(nuisance_.outliers / rate_);
  const auto wild = static_cast<std::size_t>(random_.integer(0, static_cast<int>(marker_rest.size()) - 1));
  for (std::size_t i = 0; i < marker_rest.size(); ++i) {
    Vec3 at = marker_rest[i] + Vec3(displaced.segment<3>(static_cast<Eigen::Index>(3 * i)).transpose()) +
              noise * random_.normal_vector();
    if (outlier && i == wild) at += 20.0 * random_.normal_vector().normalized();
    if (!is_lost(i)) frame_.markers.push_back({name_of(scene.markers[i].name), array_of(at), false});
  }
  const daemon::Answer previous = answer_;
  processor_->process(frame_, previous, answer_);
  note();
}

void WatchedSession::note() {
  const core::MismatchReport& now = report();
  run_.seconds = time();
  run_.highest_level = std::max(run_.highest_level, now.level);
  if (answer_.alarm.raised) {
    run_.raised_seconds += 1.0 / rate_;
    if (answer_.alarm.since_frame == answer_.tracker_frame) ++run_.raised;
  }
  if (now.raised && run_.first_raised < 0.0) run_.first_raised = time();
  // The place is looked for in the frames after the evidence.
  if (now.raised && now.has_place && !run_.place && time() >= run_.first_raised + 0.5) run_.place = now.place;
  const auto* admm = dynamic_cast<const core::AdmmSimulator*>(simulator_.get());
  if (admm == nullptr || admm->alarm() == nullptr || admm->alarm()->draws() == draws_) return;
  draws_ = admm->alarm()->draws();
  run_.evidences.push_back(admm->alarm()->evidence().lasting);
  run_.ratios.push_back(admm->alarm()->ratio());
  run_.misfits.push_back(now.misfit);
  run_.loads.push_back(admm->alarm()->load());
  run_.elements.push_back(admm->alarm()->elements());
}

AlarmRun play_null(const WatchedBody& body, const std::vector<PushCurve>& curves, double seconds, std::uint64_t seed) {
  Random random(seed);
  WatchedSession session(body.scene, Nuisance{}, seed + 1);
  const std::vector<Vec3> rests = marker_rests(body.truth);
  const std::vector<core::PadInput> none(body.scene.pads.size());
  const Eigen::RowVectorXd at_rest = curves.front().at(0.0);
  const auto rest = [&](double duration) {
    for (double t = 0.0; t < duration; t += 1.0 / body.scene.rate) session.step(none, at_rest, rests);
  };
  rest(kOpening);
  while (session.time() < seconds) {
    const auto which = static_cast<std::size_t>(random.integer(0, static_cast<int>(body.pushes.size()) - 1));
    const Push& push = body.pushes[which];
    const Course course = random_course(push, random);
    for (double t = 0.0; t <= course.back(); t += 1.0 / body.scene.rate) {
      const double share = course.share_at(t);
      session.step(pads_at(body.scene, push, share), curves[which].at(share), rests);
    }
    rest(course.rest);
  }
  return session.run();
}

std::optional<TwinRun> play_twin(const WatchedBody& body, const Twin& twin, double seconds, std::uint64_t seed) {
  Random random(seed);
  core::Scene truth = core::adjusted(body.scene, twin.effects);
  truth.markers = body.truth.markers;
  const core::RecordedTrial trial = pushed_trial(body, seconds, random);
  const core::LoadPath path(trial, truth, kTravel);
  std::vector<const core::Effect*> effects;
  for (const core::EffectSetting& setting : twin.effects) effects.push_back(setting.effect);
  core::PathSolver solver(truth, effects);
  for (const core::EffectSetting& setting : twin.effects)
    for (std::size_t k = 0; k < setting.values.size(); ++k)
      solver.set_parameter(core::model_parameter(*setting.effect, setting.effect->parameters()[k]), setting.values[k]);
  core::PathAnswer answer;
  if (!solver.solve(path, 0, {}, answer)) return std::nullopt;
  const core::RowMatrix seen = core::recorded(trial, 0, path, truth, answer.values, twin.faults);
  TwinRun run;
  WatchedSession session(body.scene, Nuisance{}, seed + 1);
  const std::vector<Vec3> rests = marker_rests(truth);
  run.first_push = kOpening;
  for (int f = 0; f < trial.frame_count(); ++f) {
    session.step(trial.pads[f], seen.row(f), rests);
    run.misfit = std::max(run.misfit, session.report().misfit);
  }
  run.alarm = session.run();
  return run;
}

}  // namespace tissued::study
