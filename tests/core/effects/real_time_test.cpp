// Every effect in the real-time step, against the judge: quadratic elements, solved to the end in every frame. What is
// compared is what the effect changes, so that the linear body's own error does not count.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/simulator.hpp"
#include "tests/core/effects/effect_checks.hpp"

using Catch::Detail::Approx;
using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

// Frames, and how long they are (s).
struct Timing {
  double frame;
  int push, hold, lift;
  int free;  // then the pad lets go: frames of 0.1 of the others
};
constexpr Timing kPushed{0.03, 20, 12, 20, 0}, kLetGo{0.03, 12, 3, 0, 60};

struct Course {
  Eigen::MatrixXd places;  // (3 (markers + targets) x frames) mm
  Eigen::MatrixXd forces;  // (3 pads x frames) N
};

SimulatorOptions options_of(const std::string& kind, const std::vector<EffectSetting>& effects, double frame) {
  SimulatorOptions options;
  options.kind = kind;
  options.solver.time_step = frame;
  options.solver.threads = 1;
  options.solver.iterations = 100;
  options.fem.dynamics = TimeScheme{TimeScheme::Kind::implicit_euler, 0.0};
  options.effects = effects;
  return options;
}

// The first pad goes in by 5 mm, obliquely, holds, and comes back or lets go.
Course course(const Scene& scene, const std::string& kind, const std::vector<EffectSetting>& effects,
              const Timing& timing) {
  constexpr double kDepth = 5.0, kFreeFrame = 0.1;
  const auto simulator = make_simulator(scene, options_of(kind, effects, timing.frame));
  Observation observation;
  observation.resize_for(scene);
  const auto markers = static_cast<Eigen::Index>(scene.markers.size()),
             targets = static_cast<Eigen::Index>(scene.targets.size()),
             pads = static_cast<Eigen::Index>(scene.pads.size());
  const int held = timing.push + timing.hold, pressed = held + timing.lift;
  Course out{Eigen::MatrixXd(3 * (markers + targets), pressed + timing.free),
             Eigen::MatrixXd(3 * pads, pressed + timing.free)};
  const Vec3 way = (scene.pads[0].direction + Vec3(0.2, 0.1, 0.0)).normalized();
  for (int f = 0; f < pressed + timing.free; ++f) {
    const double share = f < timing.push ? (f + 1.0) / timing.push
                         : f < held      ? 1.0
                                         : 1.0 - (f + 1.0 - held) / timing.lift;
    if (f == pressed) simulator->set_time_step(kFreeFrame * timing.frame);
    observation.dt = f < pressed ? timing.frame : kFreeFrame * timing.frame;
    observation.pads[0] = f < pressed ? pushed(scene.pads[0], kDepth * share * way) : PadInput{};
    const StepReport report = simulator->step(observation);
    REQUIRE(report.finite);
    for (Eigen::Index i = 0; i < markers; ++i)
      out.places.col(f).segment<3>(3 * i) = simulator->marker(static_cast<int>(i));
    for (Eigen::Index i = 0; i < targets; ++i)
      out.places.col(f).segment<3>(3 * (markers + i)) = simulator->target(static_cast<int>(i)).position;
    for (Eigen::Index i = 0; i < pads; ++i)
      out.forces.col(f).segment<3>(3 * i) = simulator->pad_force(static_cast<int>(i));
  }
  return out;
}

struct Example {
  std::string kind;
  std::vector<Chosen> numbers;
};

double rms(const Eigen::MatrixXd& matrix) { return matrix.norm() / std::sqrt(static_cast<double>(matrix.size())); }

// How much of `expected` is in `seen`, and how alike they are.
struct Likeness {
  double share, cosine;
};
Likeness likeness(const Eigen::MatrixXd& seen, const Eigen::MatrixXd& expected) {
  const double product = seen.cwiseProduct(expected).sum();
  return {product / expected.squaredNorm(), product / (seen.norm() * expected.norm())};
}

struct Change {
  double size;  // mm, RMS of what the effect changes in the judge's
  Likeness places, forces;
};
Change change_of(const Scene& scene, const Example& example, const Timing& timing) {
  const Effect& effect = *find_effect(example.kind);
  const std::vector<EffectSetting> setting{{&effect, chosen_values(effect, scene, example.numbers)}};
  const Course plain = course(scene, "admm", {}, timing), with = course(scene, "admm", setting, timing),
               judge_plain = course(scene, "fem", {}, timing), judge_with = course(scene, "fem", setting, timing);
  const Eigen::MatrixXd places = judge_with.places - judge_plain.places,
                        forces = judge_with.forces - judge_plain.forces;
  return {rms(places), likeness(with.places - plain.places, places), likeness(with.forces - plain.forces, forces)};
}

}  // namespace

TEST_CASE("In the real-time step an effect changes what it changes in the judge's") {
  const Example example = GENERATE(
      Example{"parameters", {{"youngs_modulus", 9.0}, {"poissons_ratio", 0.4}}},
      Example{"viscoelasticity", {{"g1", 0.5}, {"tau1", 0.2}}}, Example{"strain-stiffening", {{"b", 3.0}}},
      Example{"inclusion",
              {{"center.x", 15.0}, {"center.y", 15.0}, {"center.z", 12.0}, {"radius", 9.0}, {"ratio", 5.0}}},
      Example{"stiffness-gradient", {{"slope.x", 0.05}, {"slope.z", -0.03}}},
      Example{"anisotropy", {{"k", 6.0}, {"axis.x", 1.0}, {"axis.z", 0.0}}}, Example{"skin", {{"stiffness", 15.0}}},
      Example{"softening", {{"inverse_r", 0.5}, {"w0", 0.05}}}, Example{"swelling", {{"rate", 0.02}}},
      Example{"gravity", {{"gravity.x", 1.0}, {"gravity.z", -0.5}}},
      Example{"loose-base",
              {{"center.x", 15.0}, {"center.y", 15.0}, {"radius", 14.0}, {"looseness", 1.0}, {"normal_held", 1.0}}},
      Example{"loose-base",
              {{"center.x", 15.0}, {"center.y", 15.0}, {"radius", 14.0}, {"looseness", 1.0}, {"normal_held", 0.0}}},
      Example{"sliding-actuator", {{"slip", 1.0}}}, Example{"sliding-actuator", {{"slip", 0.5}}});
  const Scene scene = box_scene({5, 4, 3, 8.0}, 9);
  const Change change = change_of(scene, example, kPushed);
  CAPTURE(example.kind, change.size, change.places.share, change.places.cosine, change.forces.share,
          change.forces.cosine);
  // What is left is the elements': the linear bodies differ by as much.
  CHECK(change.places.share == Approx(1.0).margin(0.35));
  CHECK(change.places.cosine > 0.8);
  CHECK(change.forces.share == Approx(1.0).margin(0.3));
  CHECK(change.forces.cosine > 0.95);
}

TEST_CASE("In the real-time step a swinging body is slowed as in the judge's") {
  const Example example = GENERATE(
      Example{"attached-mass", {{"mass", 60.0}, {"at.x", 33.0}, {"at.y", 20.0}, {"at.z", 22.0}}},
      Example{"damping", {{"alpha", 40.0}, {"beta", 0.0}}}, Example{"damping", {{"alpha", 0.0}, {"beta", 0.05}}});
  const Scene scene = box_scene({5, 4, 3, 8.0}, 9);
  const Change change = change_of(scene, example, kLetGo);
  CAPTURE(example.kind, change.size, change.places.share, change.places.cosine);
  CHECK(change.places.share == Approx(1.0).margin(0.3));
  CHECK(change.places.cosine > 0.85);
}

TEST_CASE("In the real-time step what is attached weighs what it weighs, once") {
  Scene scene = box_scene({5, 4, 3, 8.0}, 9);
  scene.gravity = Vec3(0, 0, -1);
  const Effect& mass = *find_effect("attached-mass");
  const std::vector<EffectSetting> setting{
      {&mass, chosen_values(mass, scene, {{"mass", 60.0}, {"at.x", 33.0}, {"at.y", 20.0}, {"at.z", 22.0}})}};
  const auto hanging = [&](const std::string& kind, const std::vector<EffectSetting>& effects) {
    SimulatorOptions options = options_of(kind, effects, 0.03);
    options.fem.dynamics.reset();
    options.fem.element = FemElement::p1;
    options.solver.element = Element::p1;
    const auto simulator = make_simulator(scene, options);
    Observation observation;
    observation.resize_for(scene);
    observation.dt = 0.03;
    for (int frame = 0; frame < 100; ++frame) REQUIRE(simulator->step(observation).finite);
    Eigen::MatrixXd places(3, static_cast<Eigen::Index>(scene.markers.size()));
    for (Eigen::Index i = 0; i < places.cols(); ++i) places.col(i) = simulator->marker(static_cast<int>(i));
    return places;
  };
  const Likeness sag =
      likeness(hanging("admm", setting) - hanging("admm", {}), hanging("fem", setting) - hanging("fem", {}));
  CAPTURE(sag.share, sag.cosine);
  CHECK(sag.share == Approx(1.0).margin(0.2));
  CHECK(sag.cosine > 0.95);
}

TEST_CASE("In the real-time step a law forgets nothing with a braked step") {
  const Scene scene = box_scene({5, 4, 3, 8.0}, 9);
  const Effect& swelling = *find_effect("swelling");
  const std::vector<EffectSetting> setting{{&swelling, chosen_values(swelling, scene, {{"rate", 0.02}})}};
  std::vector<Vec3> places;
  for (const bool braked : {false, true}) {
    const auto simulator = make_simulator(scene, options_of("admm", setting, 0.03));
    Observation observation;
    observation.resize_for(scene);
    observation.dt = 0.03;
    for (int frame = 0; frame < 60; ++frame) {
      const std::atomic<std::uint64_t> pulled_for{braked && frame == 40 ? 1u : 0u};
      observation.brake = {&pulled_for, 1};
      CHECK(simulator->step(observation).braked == (braked && frame == 40));
    }
    places.push_back(simulator->marker(0) - scene.markers[0].rest);
  }
  REQUIRE(places[0].norm() > 0.05);
  CHECK((places[0] - places[1]).norm() < 0.04 * places[0].norm());  // the braked step's own 0.03 s are 2 %
}
