#include "core/effects/swelling.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("a body that swelled freely for ten seconds has the volume that its rate says, and no stress", "[effects]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({2, 2, 1, 10.0});
  FemOptions options;
  options.element = element;
  options.effects.push_back(fem_effect(swelling_effect()));
  FemModel model(scene, options);
  set_effect(model, swelling_effect(), std::vector<double>{0.02});
  FemEquilibrium equilibrium(model, 1);
  FemHistory history = rest_state(model).history;
  Eigen::VectorXd forces;
  equilibrium.accept(model.rest(), 7.0, history);
  equilibrium.terms(model.rest(), 3.0, history, forces);
  CHECK(forces.norm() > 1.0);
  equilibrium.terms(std::cbrt(1.2) * model.rest(), 3.0, history, forces);
  CHECK(forces.norm() < 1e-9);
}

TEST_CASE("swelling changes the pressure, not the answer to a change of shape", "[effects]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  const MaterialPointTwin plain(swelling_effect(), scene, {}), swollen(swelling_effect(), scene, {{"rate", -0.05}});
  Mat3 f = Mat3::Identity();
  f(0, 1) = 0.4;
  f(2, 2) = 1.2;
  const Mat3 difference = (swollen.stress(f, 2.0) - plain.stress(f, 2.0)) * f.transpose();
  const double kappa = scene.material.bulk_modulus(), j = 1.2, grown = 0.9;
  const double pressure = j * kappa * ((j / grown - 1.0) / grown - (j - 1.0));
  CHECK((difference - pressure * Mat3::Identity()).norm() < 1e-12);
}

TEST_CASE("swelling: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(swelling_effect(), {{"rate", 0.1}});
  check_neutral(swelling_effect(), 1e-12);
  check_words(swelling_effect(), {{"rate", -1e-4}});
}
