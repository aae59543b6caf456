#include "core/effects/sliding_actuator.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/fem_sensitivity.hpp"
#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

FemOptions sliding() {
  FemOptions options;
  options.effects.push_back(fem_effect(sliding_actuator_effect()));
  return options;
}

}  // namespace

TEST_CASE("a pad that slides freely pushes along its normal alone, and holds its nodes there", "[effects]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  FemModel model(scene, sliding());
  const double across = GENERATE(0.0, 1.0, 2.0);
  set_effect(model, sliding_actuator_effect(), std::vector<double>{1.0, across});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(1.5, 0.5, -3.0)), PadInput{}};
  const FemState state = solved(model, pads);
  const Vec3 force = pad_forces(state, pads)[0];
  CHECK(force.z() < -0.05);
  CHECK(force.head<2>().norm() < 1e-6);
  double slid = 0.0;
  for (const int node : model.pad_nodes()[0]) {
    const Vec3 moved = state.x.segment<3>(3 * node) - model.mesh().rest.row(node).transpose();
    CHECK(moved.z() == Approx(-3.0).margin(1e-3));
    slid = std::max(slid, (moved - Vec3(1.5, 0.5, -3.0)).norm());
  }
  CHECK(slid > 0.3);
  // What the pad's push holds up is what the rest of the body feels.
  Vec3 held = Vec3::Zero();
  for (int i = 0; i < model.mesh().node_count(); ++i)
    if (model.fixed()[i]) held += state.reaction.segment<3>(3 * i);
  CHECK((held / 1e3 + force).norm() < 1e-6);
}

TEST_CASE("a pad that is moved and turned holds its nodes where a glued one has them", "[effects]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const FemModel springs(scene, sliding()), plain(scene, {});
  std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(1.0, 0.5, -3.0)), PadInput{}};
  pads[0].rotation = Eigen::AngleAxisd(0.2, Vec3(1.0, 2.0, 0.5).normalized()).toRotationMatrix();
  const FemState one = solved(springs, pads), other = solved(plain, pads);
  CHECK((one.x - other.x).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((pad_forces(one, pads)[0] - pad_forces(other, pads)[0]).norm() < 1e-3 * pad_forces(other, pads)[0].norm());
}

TEST_CASE("a pad off the skin leaves it alone, and a sliding pad that turned pushes along its own normal",
          "[effects]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  FemModel model(scene, sliding());
  set_effect(model, sliding_actuator_effect(), std::vector<double>{1.0, 0.0});
  std::vector<PadInput> pads(2);
  CHECK((solved(model, pads).x - model.rest()).norm() < 1e-9);
  pads[0] = pushed(scene.pads[0], Vec3(0.0, 0.0, -2.0));
  pads[0].rotation = Eigen::AngleAxisd(0.1, Vec3::UnitY()).toRotationMatrix();
  const Vec3 force = pad_forces(solved(model, pads), pads)[0];
  CHECK(force.cross(pads[0].rotation.col(2)).norm() < 1e-5 * force.norm());
}

TEST_CASE("the force of a sliding pad has its derivative", "[effects]") {
  Scene scene = box_scene({3, 2, 2, 10.0});
  FemModel model(scene, sliding());
  set_effect(model, sliding_actuator_effect(), std::vector<double>{0.5, 0.0});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(1.0, 0.5, -2.0)), PadInput{}};
  const FemState state = solved(model, pads);
  FemEquilibrium equilibrium(model, 1);
  FemSensitivity sensitivity(equilibrium, state);
  const FemResponse response = sensitivity.response(sensitivity.by_parameter("youngs_modulus"));
  const double slope = derivative(sensitivity.of_pad_force(0, Vec3(0.6, 0.0, 0.8)), response);
  const auto force = [&](double modulus) {
    model.set_parameter("youngs_modulus", modulus);
    return pad_forces(solved(model, pads), pads)[0].dot(Vec3(0.6, 0.0, 0.8));
  };
  const double e = scene.material.youngs_modulus;
  CHECK(slope == Approx((force(e + 0.01) - force(e - 0.01)) / 0.02).epsilon(1e-5));
}

TEST_CASE("sliding-actuator: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(sliding_actuator_effect(), {{"slip", 0.5}});
  check_neutral(sliding_actuator_effect(), 1e-3);
  check_words(sliding_actuator_effect(), {{"slip", 1.0}});
}
