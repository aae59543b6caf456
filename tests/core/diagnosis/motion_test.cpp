// Bodies that swing: their derivatives, and what a diagnosis makes of them.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "core/diagnosis/diagnosis.hpp"
#include "core/diagnosis/path_solver.hpp"
#include "core/diagnosis/seen_motion.hpp"
#include "core/edge_load.hpp"
#include "core/fem_dynamics.hpp"
#include "tests/core/diagnosis/derivative_check.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kRate = 100.0;  // Hz

// A tower that stands on its base and is let go when its weight, and a load at its top, act sideways.
Scene tower() {
  Scene scene = box_scene({2, 2, 4, 10.0}, 9);
  scene.pads.clear();
  scene.targets.clear();
  scene.material = {25.0, 0.4, 1.0};
  scene.gravity = {1.0, 0.0, 0.0};
  scene.rate = kRate;
  return scene;
}

EdgeLoad load_at_top(double force) { return {{Vec3(0.0, 0.0, 40.0), Vec3(0.0, 20.0, 40.0)}, Vec3(force, 0.0, 0.0)}; }

RecordedTrial let_go(const Scene& scene, const std::string& name, double seconds, const std::vector<EdgeLoad>& loads) {
  RecordedTrial trial;
  trial.name = name;
  for (int f = 0; f < static_cast<int>(seconds * kRate); ++f) trial.time.push_back(f / kRate);
  trial.pads.assign(trial.time.size(), {});
  trial.seen.setConstant(trial.frame_count(), channels_of(scene).count(), std::numeric_limits<double>::quiet_NaN());
  trial.motion = Motion{0.1, true, loads};
  return trial;
}

const Effect* effect(const char* kind) { return find_effect(kind); }

}  // namespace

TEST_CASE("a load along an edge is all there, as a force and as a mass", "[diagnosis]") {
  const Scene scene = tower();
  for (const FemElement element : {FemElement::p1, FemElement::p2}) {
    FemOptions options;
    options.element = element;
    const FemModel model(scene, options);
    EdgeLoad load = load_at_top(0.3);
    load.mass = 20.0;
    const Eigen::VectorXd force = forces_of(model, {&load, 1});
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (int i = 0; i < model.mesh().node_count(); ++i) {
      sum += force.segment<3>(3 * i);
      moment += Vec3(model.mesh().rest.row(i)).cross(Vec3(force.segment<3>(3 * i)));
    }
    CHECK((sum - Vec3(300.0, 0.0, 0.0)).norm() < 1e-9);                                  // mN
    CHECK((moment - Vec3(0.0, 10.0, 40.0).cross(Vec3(300.0, 0.0, 0.0))).norm() < 1e-6);  // about its middle
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(force.size()), product;
    for (Eigen::Index i = 0; i < moved.size(); i += 3) moved[i + 2] = 1.0;
    model.pattern().multiply(masses_of(model, {&load, 1}), moved, product);
    CHECK(product.dot(moved) == Approx(0.020));  // kg
  }
}

TEST_CASE("a load where the mesh has no edges is refused with the place", "[diagnosis]") {
  const Scene scene = tower();
  const FemModel model(scene, {});
  const EdgeLoad beside{{Vec3(1.0, 0.0, 40.0), Vec3(1.0, 20.0, 40.0)}, Vec3(1.0, 0.0, 0.0)};
  CHECK_THROWS_WITH(forces_of(model, {&beside, 1}), Catch::Contains("(1, 0, 40)"));
}

TEST_CASE("a marker on a stalk turns with the body", "[diagnosis]") {
  Scene scene = tower();
  scene.markers = {{"stalk", Vec3(7.0, 11.0, 46.0)}};
  std::mt19937 generator(5);
  const Mat3 rotation = random_rotation(generator);
  const Vec3 shift(3.0, -2.0, 1.0);
  for (const FemElement element : {FemElement::p1, FemElement::p2}) {
    FemOptions options;
    options.element = element;
    const FemModel model(scene, options);
    const Eigen::VectorXd rest = model.rest();
    Eigen::VectorXd x = rest;
    for (Eigen::Index i = 0; i < x.size(); i += 3) x.segment<3>(i) = rotation * rest.segment<3>(i) + shift;
    const Vec3 at = position_of(model.marker_points()[0], x);
    CHECK((at - (rotation * scene.markers[0].rest + shift)).norm() < 1e-9);
  }
}

TEST_CASE("derivatives of a motion are those of differences", "[diagnosis]") {
  const Scene scene = tower();
  const RecordedTrial trial = let_go(scene, "loaded", 0.5, {load_at_top(0.05)});
  const LoadPath path(trial, scene, MotionSteps{});
  PathSolver solver(scene, {effect("damping"), effect("attached-mass"), effect("viscoelasticity")}, FemElement::p1);
  solver.set_parameter("attached-mass.load", 0.05);
  check_derivatives(solver, path,
                    {{"youngs_modulus", 25.0},
                     {"poissons_ratio", 0.4},
                     {"damping.alpha", 4.0},
                     {"damping.beta", 2e-3},
                     {"attached-mass.mass", 6.0},
                     {"viscoelasticity.g1", 0.2},
                     {"viscoelasticity.tau1", 0.1}},
                    2e-2, 0.05);
}

TEST_CASE("a swing is stepped through until it is calm, and where it settles nothing is compared", "[diagnosis]") {
  const Scene scene = tower();
  RecordedTrial trial = let_go(scene, "t", 6.0, {});
  for (int f = 0; f < trial.frame_count(); ++f) {
    const double since = trial.time[f] - 0.1;
    const double swing =
        since < 0.0 ? 0.0 : 1.0 - std::exp(-3.0 * since) * std::cos(2.0 * std::numbers::pi * 5.0 * since);
    for (int m = 0; m < 9; ++m) trial.seen.row(f).segment<3>(3 * m) = Eigen::RowVector3d(8.0 * swing, 0.0, 0.0);
  }
  const LoadPath all(trial, scene, MotionSteps{});
  CHECK(all.peak_load() > 8.0);
  CHECK(all.peak_load() < 8.0 * (1.0 + std::exp(-0.3)));
  CHECK(period_of(trial) == Approx(0.2).epsilon(0.05));
  for (double time : trial.time) CHECK(all.shows(time));
  CHECK(all.keys().back().time == Approx(trial.time.back()));
  CHECK(all.keys().back().settles);
  const LoadPath first(trial, scene, MotionSteps{0.01, 0.3});
  CHECK(first.shows(0.35));
  CHECK_FALSE(first.shows(0.6));
  CHECK(first.shows(5.0));
  CHECK(first.keys().size() < all.keys().size() / 2);
}

namespace {

// What the markers of a body with these effects show, with noise.
void record(RecordedSession& session, PathSolver& truth, unsigned seed) {
  std::mt19937 generator(seed);
  for (RecordedTrial& trial : session.trials) {
    const LoadPath path(trial, session.scene, MotionSteps{0.001});
    PathAnswer answer;
    REQUIRE(truth.solve(path, 0, {}, answer));
    trial.seen = recorded(trial, 0, path, session.scene, answer.values, {});
    for (Eigen::Index f = 0; f < trial.seen.rows(); ++f)
      for (Eigen::Index c = 0; c < trial.seen.cols(); ++c) trial.seen(f, c) += 0.03 * symmetric_random(generator);
  }
}

void check_found(const Diagnosis& diagnosis, const std::string& name, double truth) {
  for (const Finding& finding : diagnosis.findings)
    for (const FindingNumber& number : finding.parameters) {
      if (finding.kind + "." + number.name != name) continue;
      CAPTURE(name, truth, number.sd[0]);
      CHECK(number.value[0] == Approx(truth).margin(3.0 * number.sd[0]));
      CHECK(number.sd[0] < truth / 2.0);
      return;
    }
  FAIL_CHECK(name << " was not found");
}

}  // namespace

TEST_CASE("of a body that swings and creeps, both relaxation times are found", "[diagnosis]") {
  RecordedSession session;
  session.scene = tower();
  session.marker_noise = session.scene.marker_noise = 0.02;
  session.trials = {let_go(session.scene, "own weight", 3.0, {})};
  PathSolver truth(session.scene, {effect("viscoelasticity")});
  truth.set_parameter("youngs_modulus", 30.0);
  for (const auto& [name, value] : {std::pair{"g1", 0.25}, {"tau1", 0.9}, {"g2", 0.15}, {"tau2", 0.04}})
    truth.set_parameter(std::string("viscoelasticity.") + name, value);
  record(session, truth, 12);
  const Diagnosis diagnosis = diagnose(session, SearchOptions{});
  CHECK(diagnosis.verdict == Verdict::missing_physics);
  check_found(diagnosis, "viscoelasticity.g1", 0.25);
  check_found(diagnosis, "viscoelasticity.tau1", 0.9);
  check_found(diagnosis, "viscoelasticity.g2", 0.15);
  check_found(diagnosis, "viscoelasticity.tau2", 0.04);
}

TEST_CASE("of a body that swings, its damping and the mass of its load are found", "[diagnosis]") {
  RecordedSession session;
  session.scene = tower();
  session.marker_noise = session.scene.marker_noise = 0.02;
  session.trials = {let_go(session.scene, "own weight", 1.5, {}),
                    let_go(session.scene, "loaded", 1.5, {load_at_top(0.1)})};
  PathSolver truth(session.scene, {effect("damping"), effect("attached-mass")});
  truth.set_parameter("youngs_modulus", 27.0);
  truth.set_parameter("damping.alpha", 9.0);
  truth.set_parameter("attached-mass.load", 0.1);
  truth.set_parameter("attached-mass.mass", 10.2);
  record(session, truth, 11);
  const Diagnosis diagnosis = diagnose(session, SearchOptions{});
  CHECK(diagnosis.verdict == Verdict::missing_physics);
  std::set<std::string> kinds;
  for (const Finding& finding : diagnosis.findings) kinds.insert(finding.kind);
  CHECK(kinds.contains("damping"));
  REQUIRE(kinds.contains("attached-mass"));
  CHECK_FALSE(kinds.contains("viscoelasticity"));
  for (const Finding& finding : diagnosis.findings) {
    if (finding.kind == "attached-mass") CHECK(finding.parameters[0].value[0] == Approx(10.2).epsilon(0.1));
    if (finding.kind == "damping") CHECK(finding.parameters[0].value[0] == Approx(9.0).epsilon(0.2));
  }
  CHECK(diagnosis.trials.explained.marker_mm < 0.1 * diagnosis.trials.assumed.marker_mm);
}
