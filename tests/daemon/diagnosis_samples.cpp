#include "tests/daemon/diagnosis_samples.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "config/bundle.hpp"
#include "daemon/scene_loader.hpp"

namespace tissued::daemon {
namespace {

using core::Vec3;

constexpr double kNoise = 0.1;              // mm
constexpr double kRate = 50.0;              // Hz
constexpr double kRamp = 2.0, kHold = 3.0;  // s

struct SampleTrial {
  const char* name;
  std::vector<std::size_t> pads;
  double push;  // mm
  bool held_out;
};

const std::vector<SampleTrial> kTrials{{"a1-14", {0}, 14.0, false},
                                       {"a2-11-fast", {1}, 11.0, false},
                                       {"a34-11", {2, 3}, 11.0, false},
                                       {"held-a12-10", {0, 1}, 10.0, true}};

// How much of each misfit a model leaves, beside noise: share of the load, and of the lump's part in it.
struct SampleMisfit {
  double assumed, parameters, explained;  // mm at a load of 14 mm
};

double load_at(double time, double push) {
  if (time < 0.5) return 0.0;
  if (time < 0.5 + kRamp) return push * (time - 0.5) / kRamp;
  return time < 0.5 + kRamp + kHold ? push : std::max(0.0, push * (0.5 + 2.0 * kRamp + kHold - time) / kRamp);
}

core::TrialCourse course_of(const SampleTrial& trial, const SampleMisfit& misfit, bool forces) {
  std::mt19937 random(static_cast<unsigned>(trial.push) + (trial.held_out ? 100 : 0));
  std::normal_distribution<double> noise(0.0, 0.012);
  core::TrialCourse course;
  course.name = trial.name;
  course.held_out = trial.held_out;
  for (double time = 0.0; time < 8.0; time += 1.0 / kRate) {
    const double load = load_at(time, trial.push);
    const auto with = [&](double share) { return std::hypot(kNoise, share * load / 14.0) + noise(random); };
    course.time.push_back(time);
    course.load.push_back(load);
    course.assumed_mm.push_back(with(misfit.assumed));
    course.parameters_mm.push_back(with(misfit.parameters));
    course.explained_mm.push_back(with(misfit.explained));
    if (!forces) continue;
    const double force = 0.11 * load * (1.0 + 0.03 * load);
    course.force_seen_N.push_back(force + noise(random));
    course.force_assumed_N.push_back(force * (1.0 - 0.14 * misfit.assumed));
    course.force_explained_N.push_back(force * (1.0 + 0.01 * misfit.explained));
  }
  for (std::size_t i = 120; i < 150; ++i) course.assumed_mm[i] = course.parameters_mm[i] = course.explained_mm[i] = NAN;
  return course;
}

// A dent below every pad, and its change by the lump at `place`.
std::vector<core::MarkerMisfit> markers_of(const core::Scene& scene, const SampleTrial& trial, const Vec3& place,
                                           const SampleMisfit& misfit) {
  std::vector<core::MarkerMisfit> markers;
  for (std::size_t m = 0; m < scene.markers.size(); ++m) {
    const Vec3 rest = scene.markers[m].rest;
    Vec3 dent = Vec3::Zero();
    for (const std::size_t p : trial.pads) {
      const core::Pad& pad = scene.pads[p];
      const double near = std::exp(-(rest - pad.center).squaredNorm() / (2.0 * 30.0 * 30.0));
      dent += trial.push * (near * pad.direction + 0.18 * near * Vec3::UnitZ());
    }
    const Vec3 away = (rest - place).normalized();
    const double felt = 3.0 * std::exp(-(rest - place).squaredNorm() / (2.0 * 28.0 * 28.0)) * trial.push / 14.0;
    const Vec3 jitter(0.06 * std::sin(7.0 * static_cast<double>(m)), 0.06 * std::cos(5.0 * static_cast<double>(m)),
                      0.0);
    markers.push_back({trial.name, scene.markers[m].name, rest, dent + felt * misfit.assumed * away + jitter, dent,
                       dent + felt * (misfit.assumed - misfit.explained) * away});
  }
  return markers;
}

std::vector<double> map_around(const core::Scene& scene, const Vec3& place, double width) {
  std::vector<double> map;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> speckle(0.0, 0.12);
  for (const core::Tet& tet : scene.mesh.tets) {
    Vec3 middle = Vec3::Zero();
    for (const int node : tet) middle += 0.25 * scene.mesh.node(node);
    map.push_back(0.88 * std::exp(-(middle - place).squaredNorm() / (2.0 * width * width)) + speckle(random));
  }
  return map;
}

core::Diagnosis session(const core::Scene& scene, const Vec3& place, const SampleMisfit& misfit, bool forces) {
  core::Diagnosis diagnosis;
  diagnosis.bundle = scene.name;
  diagnosis.noise_marker_mm = kNoise;
  diagnosis.noise_force_N = forces ? 0.012 : NAN;
  diagnosis.discretisation_marker_mm = 0.06;
  diagnosis.seconds = 41.3;
  for (const SampleTrial& trial : kTrials) {
    diagnosis.courses.push_back(course_of(trial, misfit, forces));
    const auto markers = markers_of(scene, trial, place, misfit);
    diagnosis.markers.insert(diagnosis.markers.end(), markers.begin(), markers.end());
  }
  return diagnosis;
}

}  // namespace

core::Scene demo_scene() { return load_scene(config::load_bundle(TISSUED_SOURCE_DIR "/config/demo")); }

core::Diagnosis inclusion_sample(const core::Scene& scene) {
  const Vec3 place(24.0, 6.0, 30.0);
  core::Diagnosis diagnosis = session(scene, place, {1.1, 0.72, 0.07}, true);
  diagnosis.verdict = core::Verdict::missing_physics;
  core::Finding lump;
  lump.kind = "inclusion";
  lump.probability = 0.968;
  lump.title = "There is a lump of other stiffness in the tissue";
  lump.summary = "A lump of 11 mm radius around (24, 6, 30) mm is 4.2 times as stiff as the tissue around it.";
  lump.where = core::Finding::Place{place, 11.0};
  lump.trials = {"a1-14"};
  lump.phase = "hold";
  lump.parameters = {{"center", "mm", {24.0, 6.0, 30.0}, {0.9, 1.1, 1.6}},
                     {"radius", "mm", {11.2}, {0.8}},
                     {"ratio", "1", {4.2}, {0.7}}};
  diagnosis.findings = {lump};
  diagnosis.alternatives = {{"stiffness-gradient", 0.021, 1302.0},
                            {"anisotropy", 0.008, 1377.0},
                            {"strain-stiffening", 0.002, 1410.0},
                            {"marker-slip", 0.0004, 1466.0}};
  diagnosis.trials = {{0.81, 0.66, 0.21}, {0.54, 0.47, 0.12}, {0.122, 0.31, 0.013}};
  diagnosis.held_out = {{0.74, 0.62, NAN}, {0.55, 0.49, NAN}, {0.128, 0.32, NAN}};
  diagnosis.held_out_seen = true;
  diagnosis.next_experiment =
      "Push A3 by 14 mm against the lump's far side: a lump and a gradient of stiffness then differ by 0.6 mm at M03, "
      "six times the noise.";
  diagnosis.remarks = {"In 30 frames of a1-14 no marker was seen.", "Held-out forces were not recorded."};
  diagnosis.mismatch_map = map_around(scene, place, 15.0);
  return diagnosis;
}

core::Diagnosis no_mismatch_sample(const core::Scene& scene) {
  core::Diagnosis diagnosis = session(scene, Vec3(0, 0, 30), {0.03, 0.025, 0.025}, false);
  diagnosis.verdict = core::Verdict::no_mismatch;
  diagnosis.alternatives = {{"parameters", 0.012, 1201.0}, {"viscoelasticity", 0.007, 1203.0}, {"skin", 0.003, 1204.0}};
  diagnosis.trials = {{0.104, NAN, NAN}, {0.102, NAN, NAN}, {0.102, NAN, NAN}};
  diagnosis.held_out = {{NAN, NAN, NAN}, {NAN, NAN, NAN}, {NAN, NAN, NAN}};
  diagnosis.remarks = {"No forces were recorded: stiffness cannot be told, only its ratios.",
                       "The held-out recording holds pads alone: there is nothing to compare with."};
  return diagnosis;
}

core::Diagnosis unexplained_sample(const core::Scene& scene) {
  const Vec3 place(-20.0, 10.0, 22.0);
  core::Diagnosis diagnosis = session(scene, place, {0.9, 0.83, 0.55}, true);
  diagnosis.verdict = core::Verdict::unexplained;
  core::Finding unknown;
  unknown.kind = "unknown";
  unknown.probability = 0.91;
  unknown.title = "Something acts on the tissue that this program has no name for";
  unknown.summary = "A force of 0.8 N around (-20, 10, 22) mm, pointing upwards, would repair the simulation.";
  unknown.where = core::Finding::Place{place, 16.0};
  unknown.trials = {"a34-11", "a1-14"};
  unknown.phase = "release";
  diagnosis.findings = {unknown};
  diagnosis.alternatives = {{"inclusion", 0.05, 2100.0}, {"inclusion + viscoelasticity", 0.03, 2080.0}};
  diagnosis.trials = {{0.62, 0.7, 0.19}, {0.57, 0.6, 0.16}, {0.41, 0.5, 0.11}};
  diagnosis.held_out = {{0.58, 0.6, 0.2}, {0.56, 0.6, 0.19}, {0.44, 0.5, 0.14}};
  diagnosis.held_out_seen = true;
  diagnosis.next_experiment = "Hold A3 at 10 mm for a minute and release it slowly: what relaxes then shows in M12.";
  diagnosis.complete = false;
  diagnosis.remarks = {"Stopped by the budget of 60 s before pairs of effects were tried."};
  diagnosis.mismatch_map = map_around(scene, place, 20.0);
  return diagnosis;
}

}  // namespace tissued::daemon
