#include "core/effects/softening.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("unloaded tissue follows Ogden and Roxburgh, loaded further it is as new", "[effects]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  const double mu = scene.material.shear_modulus(), w0 = 0.2, r = 1.6;
  MaterialPointTwin point(softening_effect(), scene, {{"inverse_r", 1.0 / r}, {"w0", w0}});
  const auto sheared = [](double gamma) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = gamma;
    return f;
  };
  const auto stress = [&](double gamma) { return point.stress(sheared(gamma), 0.1)(0, 1); };
  CHECK(stress(0.6) == Approx(mu * 0.6));  // never strained before
  for (const double gamma : {0.3, 0.6, 0.2}) point.accept(sheared(gamma), 0.1);
  for (const double gamma : {0.1, 0.4, 0.59}) {
    const double eta = 1.0 - std::erf(0.5 * mu * (0.36 - gamma * gamma) / w0) / r;
    CHECK(stress(gamma) == Approx(mu * gamma * eta));
  }
  CHECK(stress(0.8) == Approx(mu * 0.8));
}

// Where one point of an element is strained further than ever and its neighbours are not, they differ in stiffness
// many times.
TEST_CASE("a body that softens stays stable while it is pushed, held and let go", "[effects]") {
  const Scene scene = box_scene({4, 4, 3, 10.0});
  FemOptions options;
  options.effects.push_back(fem_effect(softening_effect()));
  FemModel body(scene, options);
  set_effect(body, softening_effect(), std::vector<double>{0.7, 0.002 * scene.material.youngs_modulus});
  FemEquilibrium equilibrium(body, 1);
  FemState state = rest_state(body);
  for (const double depth : {2.0, 4.0, 6.0, 6.0, 6.02, 6.01, 6.0, 4.0, 2.0, 0.0}) {
    const std::vector<PadInput> pads{pushed(scene.pads[0], depth * scene.pads[0].direction), PadInput{}};
    INFO("at " << depth << " mm");
    REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{1e-4, 30, 6.0, 1e-3}, 0.1).converged);
    CHECK(equilibrium.factor_at({1.0, 0.1, nullptr, {}}, state.x, state.history, state.hold));
  }
}

TEST_CASE("softening: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(softening_effect(), {{"inverse_r", 0.6}, {"w0", 0.3}});
  check_neutral(softening_effect(), 1e-12);
  check_words(softening_effect(), {{"inverse_r", 0.6}});
}
