#include "core/effects/attached_mass.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "core/fem_dynamics.hpp"
#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

FemOptions with_mass(FemElement element) {
  FemOptions options;
  options.element = element;
  options.effects.push_back(fem_effect(attached_mass_effect()));
  return options;
}

}  // namespace

TEST_CASE("a body carries the weight of what is attached to it, at its place", "[effects]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  Scene scene = box_scene({2, 2, 2, 10.0});
  scene.gravity = Vec3(0.0, 0.0, -1.0);
  scene.material.youngs_modulus = 600.0;  // so that it does not lean
  FemModel model(scene, with_mass(element));
  const std::vector<PadInput> pads(2);
  const auto held = [&] {
    const FemState state = solved(model, pads);
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
    for (int i = 0; i < model.mesh().node_count(); ++i) {
      if (!model.fixed()[i]) continue;
      force += state.reaction.segment<3>(3 * i);
      moment += Vec3(state.x.segment<3>(3 * i)).cross(Vec3(state.reaction.segment<3>(3 * i)));
    }
    return std::pair{force, moment};
  };
  const auto bare = held();
  set_effect(model, attached_mass_effect(), std::vector<double>{0.05, 13.0, 7.0, 12.0, 0.0});
  const auto loaded = held();
  const double weight = 0.05e-3 * 9806.65;
  CHECK((loaded.first - bare.first - Vec3(0.0, 0.0, weight)).norm() < 1e-6);
  // x cross force = (y F, -x F, .) of what hangs at (13, 7).
  CHECK(loaded.second.x() - bare.second.x() == Approx(7.0 * weight).epsilon(1e-3));
  CHECK(loaded.second.y() - bare.second.y() == Approx(-13.0 * weight).epsilon(1e-3));
}

TEST_CASE("what is attached follows gravity that was set, and has inertia", "[effects]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({2, 2, 2, 10.0});
  FemModel model(scene, with_mass(element));
  FemEquilibrium equilibrium(model, 1);
  FemDynamics dynamics(equilibrium, TimeScheme{}, RayleighDamping{});
  set_effect(model, attached_mass_effect(), std::vector<double>{40.0, 13.0, 7.0, 12.0, 0.0});
  FemState state = rest_state(model);
  const std::vector<PadInput> pads(2);
  dynamics.start(state, {pads, nullptr});  // takes the mass that was set after it was made
  for (int i = 0; i < model.mesh().node_count(); ++i) state.velocity.segment<3>(3 * i) = Vec3(3.0, 0.0, -4.0);
  const double kilograms = 0.040 + 1e-6 * 8000.0;
  CHECK(dynamics.kinetic_energy(state) == Approx(0.5 * kilograms * 25.0));
  Eigen::VectorXd forces;
  model.set_parameter("gravity_x", 0.5);
  equilibrium.terms(state.x, 0.0, state.history, forces);
  double pull = 0.0;
  for (int i = 0; i < model.mesh().node_count(); ++i) pull -= forces[3 * i];
  CHECK(pull == Approx(0.5 * kilograms * 9806.65));
}

TEST_CASE("attached-mass: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(attached_mass_effect(), {{"mass", 20.0}});
  check_neutral(attached_mass_effect(), 1e-12);
  check_words(attached_mass_effect(), {{"mass", 20.0}});
}
