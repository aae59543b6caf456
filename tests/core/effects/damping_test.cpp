#include "core/effects/damping.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/fem_dynamics.hpp"
#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("damping of the body is that given to the dynamics, whenever its numbers are set", "[effects]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  FemOptions options;
  options.element = FemElement::p1;
  const FemModel plain(scene, options);
  options.effects.push_back(fem_effect(damping_effect()));
  FemModel damped(scene, options);
  FemEquilibrium one(damped, 1), other(plain, 1);
  FemDynamics of_body(one, TimeScheme{}, RayleighDamping{}), given(other, TimeScheme{}, RayleighDamping{4.0, 0.01});
  set_effect(damped, damping_effect(), std::vector<double>{4.0, 0.01});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.5, 0.0, -1.0)), PadInput{}};
  FemState a = rest_state(damped), b = rest_state(plain);
  for (int step = 0; step < 5; ++step) {
    REQUIRE(of_body.step(a, {pads, nullptr}, 0.01, FemControl{}).converged);
    REQUIRE(given.step(b, {pads, nullptr}, 0.01, FemControl{}).converged);
  }
  CHECK((a.velocity - b.velocity).norm() == 0.0);
  CHECK(a.velocity.norm() > 1.0);
}

TEST_CASE("energy of a swinging body falls as exp(-alpha t)", "[effects]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  FemOptions options;
  options.element = FemElement::p1;
  options.effects.push_back(fem_effect(damping_effect()));
  FemModel model(scene, options);
  constexpr double kAlpha = 8.0, kTime = 0.4, kStep = 5e-4;
  set_effect(model, damping_effect(), std::vector<double>{kAlpha, 0.0});
  FemEquilibrium equilibrium(model, 1);
  FemDynamics dynamics(equilibrium, {TimeScheme::Kind::generalized_alpha, 1.0}, RayleighDamping{});
  FemState state = rest_state(model);
  const std::vector<PadInput> pads(2);
  // A small shear, let go.
  for (int i = 0; i < model.mesh().node_count(); ++i) state.x[3 * i] += 1e-3 * model.mesh().rest(i, 2);
  dynamics.start(state, {pads, nullptr});
  Eigen::VectorXd forces;
  const auto energy = [&] {
    return dynamics.kinetic_energy(state) + equilibrium.terms(state.x, 0.0, state.history, forces);
  };
  const double begin = energy();
  for (int step = 0; step < static_cast<int>(kTime / kStep); ++step)
    REQUIRE(dynamics.step(state, {pads, nullptr}, kStep, FemControl{}).converged);
  CHECK(energy() == Approx(begin * std::exp(-kAlpha * kTime)).epsilon(0.1));
}

TEST_CASE("damping: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(damping_effect(), {{"alpha", 3.0}});
  check_neutral(damping_effect(), 1e-12);
  check_words(damping_effect(), {{"alpha", 3.0}});
}
