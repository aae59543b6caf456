#include "core/effects/strain_stiffening.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("sheared by gamma, stiffening tissue answers with mu gamma exp(b gamma^2)", "[effects]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  const double mu = scene.material.shear_modulus();
  for (const double b : {1e-9, 0.5, 3.0}) {
    const MaterialPointTwin point(strain_stiffening_effect(), scene, {{"b", b}});
    for (const double gamma : {0.01, 0.3, 0.8}) {
      Mat3 f = Mat3::Identity();
      f(0, 1) = gamma;
      CHECK(point.stress(f, 0.0)(0, 1) == Approx(mu * gamma * std::exp(b * gamma * gamma)).epsilon(1e-12));
    }
  }
}

TEST_CASE("a bar that hardly changes its volume follows the closed form in tension and in compression", "[effects]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  scene.material.poissons_ratio = 0.4999;
  const double mu = scene.material.shear_modulus(), b = 2.0;
  const MaterialPointTwin point(strain_stiffening_effect(), scene, {{"b", b}});
  for (const double stretch : {0.7, 0.9, 1.2, 1.5}) {
    const double invariant = stretch * stretch + 2.0 / stretch - 3.0;
    const double expected = mu * std::exp(b * invariant) * (stretch - 1.0 / (stretch * stretch));
    CHECK(point.bar_stress(stretch, 0.0) == Approx(expected).epsilon(3e-3));
  }
}

TEST_CASE("strain-stiffening: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(strain_stiffening_effect(), {{"b", 1.5}});
  check_derivatives(strain_stiffening_effect(), {{"b", 1e-6}});
  check_neutral(strain_stiffening_effect(), 1e-12);
  check_words(strain_stiffening_effect(), {{"b", 1.5}});
}
