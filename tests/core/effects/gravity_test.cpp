#include "core/effects/gravity.hpp"

#include <catch2/catch.hpp>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("weight as an effect is the weight of a scene that knew it", "[effects]") {
  Scene scene = box_scene({2, 2, 2, 10.0});
  FemOptions options;
  options.effects.push_back(fem_effect(gravity_effect()));
  FemModel unaware(scene, options);
  set_effect(unaware, gravity_effect(), std::vector<double>{0.5, 0.0, -0.8});
  scene.gravity = Vec3(0.5, 0.0, -0.8);
  const FemModel aware(scene, {});
  const std::vector<PadInput> pads(2);
  Eigen::VectorXd x[2];
  for (const FemModel* model : std::initializer_list<const FemModel*>{&unaware, &aware}) {
    FemEquilibrium equilibrium(*model, 1);
    FemState state = rest_state(*model);
    REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
    x[model == &aware] = state.x;
  }
  CHECK((x[0] - aware.rest()).norm() > 1.0);
  CHECK((x[0] - x[1]).norm() == 0.0);
}

TEST_CASE("a sentence has no negative zeros", "[effects]") {
  CHECK(gravity_effect().sentence(std::vector<double>{-1.0, -1e-9, 0.0}) ==
        "The tissue's weight acts with 1.00 g along (-1.00, 0.00, 0.00).");
}

TEST_CASE("gravity: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(gravity_effect(), {{"gravity.x", 1.0}});
  check_neutral(gravity_effect(), 1e-12);
  check_words(gravity_effect(), {{"gravity.x", 1.0}});
}
