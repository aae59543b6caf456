#include "core/effects/parameters.hpp"

#include <catch2/catch.hpp>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("the body's numbers as an effect are those of a scene that knew them", "[effects]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  scene.gravity = Vec3(0.0, 0.0, -1.0);
  FemOptions options;
  options.effects.push_back(fem_effect(parameters_effect()));
  FemModel told(scene, options);
  CHECK(told.parameter("parameters.youngs_modulus") == scene.material.youngs_modulus);
  set_effect(told, parameters_effect(), std::vector<double>{9.0, 0.41, 1.7});
  scene.material = {9.0, 0.41, 1.7};
  const FemModel knew(scene, {});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.3, 0.0, -1.0)), PadInput{}};
  const FemState one = solved(told, pads), other = solved(knew, pads);
  CHECK((one.x - other.x).norm() == 0.0);
  CHECK(pad_forces(one, pads)[0] == pad_forces(other, pads)[0]);
}

TEST_CASE("parameters: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(parameters_effect(), {{"youngs_modulus", 9.0}});
  check_neutral(parameters_effect(), 1e-12);
  check_words(parameters_effect(), {{"youngs_modulus", 9.0}});
}

TEST_CASE("the registry knows every kind of the contract that is physics, once", "[effects]") {
  const std::vector<std::string> kinds{
      "parameters", "viscoelasticity", "strain-stiffening", "inclusion", "stiffness-gradient", "anisotropy",
      "skin",       "softening",       "swelling",          "gravity",   "loose-base",         "sliding-actuator",
      "damping",    "attached-mass"};
  REQUIRE(effects().size() == kinds.size());
  for (std::size_t k = 0; k < kinds.size(); ++k) CHECK(effects()[k]->kind() == kinds[k]);
  CHECK(find_effect("magic") == nullptr);
}

TEST_CASE("a body with every effect at once, all neutral, answers as the plain one", "[effects]") {
  Scene scene = box_scene({2, 2, 2, 10.0});
  FemOptions options, same_points;
  for (const Effect* effect : effects()) options.effects.push_back(fem_effect(*effect));
  same_points.quadrature_degree = 2;
  const FemModel all(scene, options), plain(scene, same_points);
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.3, 0.0, -2.0)), PadInput{}};
  const FemState one = solved(all, pads), other = solved(plain, pads);
  CHECK((one.x - other.x).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((pad_forces(one, pads)[0] - pad_forces(other, pads)[0]).norm() < 1e-4);
}
