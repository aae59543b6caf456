#include "core/effects/viscoelasticity.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/neo_hookean.hpp"
#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

const std::vector<Chosen> kTwoBranches{{"g1", 0.3}, {"tau1", 0.5}, {"g2", 0.2}, {"tau2", 3.0}};

Mat3 sheared() {
  Mat3 f = Mat3::Identity();
  f(0, 2) = 0.4;
  f(1, 1) = 1.1;
  return f;
}

}  // namespace

TEST_CASE("after a jump the stress of shape follows the Prony series, that of volume stays, for any steps",
          "[effects]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  MaterialPointTwin point(viscoelasticity_effect(), scene, kTwoBranches);
  const Mat3 f = sheared();
  const Mat3 shape = first_piola(scene.material.shear_modulus(), 0.0, f);
  const Mat3 volume = first_piola(0.0, scene.material.bulk_modulus(), f);
  CHECK((point.stress(f, 0.0) - shape - volume).norm() < 1e-12);  // the assumed modulus is the instantaneous one
  point.accept(f, 0.0);
  double time = 0.0;
  for (const double step : {0.01, 0.5, 0.04, 7.0, 1e3}) {
    time += step;
    const double left = 1.0 - 0.3 * (1.0 - std::exp(-time / 0.5)) - 0.2 * (1.0 - std::exp(-time / 3.0));
    CHECK((point.stress(f, step) - left * shape - volume).norm() < 1e-12);
    point.accept(f, step);
  }
}

TEST_CASE("a small ramp follows the closed form of a Prony series, without error from the size of the step",
          "[effects]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  MaterialPointTwin point(viscoelasticity_effect(), scene, {{"g1", 0.6}, {"tau1", 0.5}});
  constexpr double kRate = 1e-6;  // 1/s, so that the answer is linear
  double time = 0.0;
  for (const double step : {0.3, 0.3, 1.2}) {
    time += step;
    Mat3 f = Mat3::Identity();
    f(0, 1) = kRate * time;
    // Shear stress mu (share kept) gamma + g tau (1 - e^(-t/tau)) gamma'.
    const double mu = scene.material.shear_modulus();
    const double expected = mu * kRate * (0.4 * time + 0.6 * 0.5 * (1.0 - std::exp(-time / 0.5)));
    CHECK(point.stress(f, step)(0, 1) == Approx(expected).epsilon(1e-5));
    point.accept(f, step);
  }
}

TEST_CASE("a held body of half the Prony share answers in the end as one of half the shear modulus", "[effects]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  FemOptions options;
  options.effects.push_back(fem_effect(viscoelasticity_effect()));
  FemModel relaxing(scene, options);
  set_effect(relaxing, viscoelasticity_effect(), std::vector<double>{0.5, 0.1, 0.0, 5.0});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.5, 0.0, -1.5)), PadInput{}};
  FemEquilibrium equilibrium(relaxing, 1);
  FemState state = rest_state(relaxing);
  for (const double step : {0.0, 1.0, 20.0, 20.0})
    REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}, step).converged);
  // mu / 2 at the same kappa.
  const double mu = 0.5 * scene.material.shear_modulus(), kappa = scene.material.bulk_modulus();
  scene.material.youngs_modulus = 9.0 * kappa * mu / (3.0 * kappa + mu);
  scene.material.poissons_ratio = (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu));
  FemOptions same_points;
  same_points.quadrature_degree = 2;
  const FemModel soft(scene, same_points);
  FemEquilibrium other(soft, 1);
  FemState expected = rest_state(soft);
  REQUIRE(solve_static(other, expected, {pads}, FemControl{}).converged);
  CHECK((state.x - expected.x).cwiseAbs().maxCoeff() < 1e-6);
  CHECK((pad_forces(state, pads)[0] - pad_forces(expected, pads)[0]).norm() < 1e-6);
}

TEST_CASE("viscoelasticity follows the body's moduli", "[effects]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  FemOptions options;
  options.effects.push_back(fem_effect(viscoelasticity_effect()));
  FemModel model(scene, options);
  set_effect(model, viscoelasticity_effect(), std::vector<double>{0.5, 0.1, 0.1, 5.0});
  FemEquilibrium equilibrium(model, 1);
  FemHistory history = rest_state(model).history;
  Eigen::VectorXd x = model.rest(), before, after;
  for (int i = 0; i < model.mesh().node_count(); ++i) x[3 * i] += 0.2 * model.mesh().rest(i, 2);
  equilibrium.accept(x, 0.1, history);
  equilibrium.terms(x, 0.1, history, before);
  model.set_parameter("youngs_modulus", 2.0 * scene.material.youngs_modulus);
  equilibrium.terms(x, 0.1, history, after);
  CHECK((after - 2.0 * before).norm() < 1e-10 * before.norm());
}

TEST_CASE("viscoelasticity: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(viscoelasticity_effect(), kTwoBranches);
  check_neutral(viscoelasticity_effect(), 1e-12);
  check_words(viscoelasticity_effect(), kTwoBranches);
  check_words(viscoelasticity_effect(), {{"g1", 0.3}});
}
