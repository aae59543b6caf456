#include "core/effects/loose_base.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

const std::vector<Chosen> kEverywhere{{"radius", 200.0}, {"looseness", 1.0}, {"normal_held", 0.0}};

FemState answer(const Scene& scene, const std::vector<Chosen>& chosen, const std::vector<PadInput>& pads) {
  FemOptions options;
  options.effects.push_back(fem_effect(loose_base_effect()));
  FemModel model(scene, options);
  set_effect(model, loose_base_effect(), chosen_values(loose_base_effect(), scene, chosen));
  return solved(model, pads);
}

}  // namespace

TEST_CASE("a body whose whole support is let go answers as one that has none", "[effects]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.3, 0.0, -2.0)),
                                   pushed(scene.pads[1], Vec3(0.0, 0.5, 0.0))};
  FemOptions unsupported;
  unsupported.effects.push_back([](const Scene&, const FemMesh&, FemPhysics& physics) { physics.fixed_nodes.clear(); });
  const FemModel floating(scene, unsupported);
  const FemState expected = solved(floating, pads), loose = answer(scene, kEverywhere, pads);
  CHECK((loose.x - expected.x).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((pad_forces(loose, pads)[0] - pad_forces(expected, pads)[0]).norm() < 1e-4);
}

TEST_CASE("a support that slides holds across and gives along, only where it is loose", "[effects]") {
  const Scene scene = box_scene({4, 3, 2, 10.0});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(1.0, 0.0, -4.0)), PadInput{}};
  const FemState state =
      answer(scene, {{"center.x", 5.0}, {"center.y", 10.0}, {"radius", 8.0}, {"looseness", 1.0}}, pads);
  const FemMesh mesh = make_fem_mesh(scene.mesh, FemElement::p2);
  double along = 0.0, elsewhere = 0.0, across = 0.0;
  for (const int node : nodes_of(mesh, *scene.mesh.find_surface("base"))) {
    const Vec3 rest = mesh.rest.row(node).transpose(), moved = state.x.segment<3>(3 * node) - rest;
    const double distance = (rest - Vec3(5.0, 10.0, 0.0)).norm();
    across = std::max(across, std::abs(moved.z()));
    if (distance < 6.0) along = std::max(along, moved.head<2>().norm());
    if (distance > 25.0) elsewhere = std::max(elsewhere, moved.norm());
  }
  CHECK(along > 0.1);
  CHECK(across < 1e-3);
  CHECK(elsewhere < 1e-3);
}

TEST_CASE("what a support gives grows evenly with its looseness from the start", "[effects]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(1.0, 0.0, 0.0)), PadInput{}};
  const FemState held = answer(scene, {{"radius", 10.0}}, pads);
  const double one = (answer(scene, {{"radius", 10.0}, {"looseness", 0.002}}, pads).x - held.x).norm();
  const double two = (answer(scene, {{"radius", 10.0}, {"looseness", 0.004}}, pads).x - held.x).norm();
  CHECK(two == Approx(2.0 * one).epsilon(0.05));
}

TEST_CASE("loose-base: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(loose_base_effect(), {{"radius", 8.0}, {"looseness", 0.6}, {"normal_held", 0.0}});
  check_neutral(loose_base_effect(), 1e-3);
  check_words(loose_base_effect(), {{"looseness", 1.0}});
}
