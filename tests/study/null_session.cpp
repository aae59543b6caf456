#include "tests/study/null_session.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "core/refined_mesh.hpp"
#include "tests/study/body.hpp"
#include "tests/study/random_scene.hpp"

namespace tissued::study {

namespace {

using core::Channels;
using core::Scene;
using core::Vec3;

constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();

// What is never seen of a session, and how often markers are lost.
struct Sight {
  std::vector<std::uint8_t> marker_is_lost;  // (markers) throughout
  double gap_chance = 0.0;                   // of a marker in a trial
  bool has_force = false, has_targets = false;
};

Sight random_sight(const Scene& scene, Random& random) {
  Sight sight;
  sight.has_force = random.chance(0.6);
  sight.has_targets = random.chance(0.3);
  sight.marker_is_lost.assign(scene.markers.size(), 0);
  if (random.chance(0.3)) return sight;
  sight.gap_chance = random.uniform(0.05, 0.4);
  const int lost = random.integer(0, 2), last = static_cast<int>(scene.markers.size()) - 1;
  for (int i = 0; i < lost; ++i) sight.marker_is_lost[static_cast<std::size_t>(random.integer(0, last))] = 1;
  return sight;
}

void lose_markers(const Channels& channels, const Sight& sight, Random& random, core::RecordedTrial& trial) {
  const int frames = trial.frame_count();
  for (int i = 0; i < channels.markers; ++i) {
    const auto begin = static_cast<int>(random.uniform(0.0, 0.9) * frames);
    const int length = std::min(frames - begin, static_cast<int>(random.uniform(0.1, 0.5) * frames));
    if (random.chance(sight.gap_chance)) trial.seen.block(begin, channels.of_marker(i), length, 3).setConstant(kUnseen);
    if (sight.marker_is_lost[i]) trial.seen.middleCols<3>(channels.of_marker(i)).setConstant(kUnseen);
  }
  if (!sight.has_targets) trial.seen.middleCols(3 * channels.markers, 3 * channels.targets).setConstant(kUnseen);
  if (!sight.has_force) trial.seen.rightCols(3 * channels.pads).setConstant(kUnseen);
}

// From what the body did to what is recorded of it.
void measure(const core::RecordedSession& session, const Scene& truth, const Sight& sight, Random& random,
             core::RecordedTrial& trial) {
  const Channels channels = core::channels_of(session.scene);
  for (int i = 0; i < channels.markers; ++i)
    trial.seen.middleCols<3>(channels.of_marker(i)).rowwise() +=
        (truth.markers[i].rest - session.scene.markers[i].rest).transpose();
  for (Eigen::Index f = 0; f < trial.seen.rows(); ++f)
    for (int c = 0; c < channels.count(); ++c) trial.seen(f, c) += session.noise_of(c) * random.normal();
  lose_markers(channels, sight, random, trial);
}

void set_numbers(Random& random, NullSession& null, Scene& truth) {
  Scene& scene = null.session.scene;
  scene.material.youngs_modulus = random.logarithmic(2.0, 20.0);
  scene.material.poissons_ratio = random.uniform(0.40, 0.49);
  truth.material = scene.material;
  if (random.chance(0.7)) truth.material.youngs_modulus *= random.logarithmic(0.5, 2.0);
  if (random.chance(0.7)) truth.material.poissons_ratio = random.uniform(0.40, 0.49);
  null.youngs_modulus = truth.material.youngs_modulus;
  null.poissons_ratio = truth.material.poissons_ratio;
  null.session.marker_noise = scene.marker_noise = truth.marker_noise = random.logarithmic(0.05, 0.2);
  null.session.force_noise = random.logarithmic(0.005, 0.02);
  null.marker_offset = random.uniform(0.3, 0.5);
  scene.rate = truth.rate = random.uniform(10.0, 25.0);
}

void count_frames(NullSession& null) {
  const Channels channels = core::channels_of(null.session.scene);
  double seen = 0.0, all = 0.0;
  for (const core::RecordedTrial& trial : null.session.trials) {
    null.frames += trial.frame_count();
    seen += static_cast<double>(trial.seen.leftCols(3 * channels.markers).array().isFinite().count());
    all += static_cast<double>(3 * channels.markers * trial.frame_count());
  }
  null.missing = 1.0 - seen / all;
}

std::optional<NullSession> drawn(std::uint64_t seed, Random& random) {
  NullSession null;
  null.seed = seed;
  Scene& scene = null.session.scene;
  Body body = random_body(random);
  null.shape = body.shape;
  scene.name = "null-" + std::to_string(seed);
  scene.mesh = std::move(body.mesh);
  add_pads(scene, random);
  if (scene.pads.empty()) return std::nullopt;
  Scene truth = scene;
  truth.mesh = core::refined(scene.mesh);
  set_numbers(random, null, truth);
  add_points(null.marker_offset, random, scene, truth);
  const Sight sight = random_sight(scene, random);
  null.has_force = sight.has_force;
  null.has_targets = sight.has_targets;
  const std::vector<Push> pushes = random_pushes(scene, random);
  std::vector<PushCurve> curves;
  for (const Push& push : pushes) {
    std::optional<PushCurve> curve = PushCurve::solve(truth, push);
    if (!curve) return std::nullopt;
    curves.push_back(std::move(*curve));
  }
  const int trials = random.integer(3, 5);
  for (int k = 0; k <= trials; ++k) {
    const std::size_t which = static_cast<std::size_t>(k) % pushes.size();
    const double deepest = *std::max_element(pushes[which].depths.begin(), pushes[which].depths.end());
    Course course;
    course.share = k < static_cast<int>(pushes.size()) ? 1.0 : random.uniform(std::min(1.0, 3.0 / deepest), 1.0);
    course.ramp = course.share * deepest / random.logarithmic(3.0, 25.0);
    course.hold = random.uniform(0.5, 2.0);
    course.rest = random.uniform(0.3, 0.8);
    const std::string name = (k < trials ? "trial-" : "held-") + std::to_string(k + 1);
    core::RecordedTrial trial = recorded_push(scene, name, pushes[which], course, curves[which]);
    measure(null.session, truth, sight, random, trial);
    (k < trials ? null.session.trials : null.session.held_out).push_back(std::move(trial));
  }
  count_frames(null);
  return null;
}

}  // namespace

NullSession draw_null(std::uint64_t seed) {
  Random random(seed);
  for (int redraws = 0;; ++redraws) {
    std::optional<NullSession> null;
    try {
      null = drawn(seed, random);
    } catch (const core::ModelError&) {
      // A body that no model can be made of: an element turned inside out, a pad without a node of its own.
    }
    if (!null) continue;
    null->redraws = redraws;
    return *null;
  }
}

}  // namespace tissued::study
