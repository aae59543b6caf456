#include "core/effects/stiffness_gradient.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("a stiffness that varies answers as a body whose points were given it", "[effects]") {
  const Scene scene = box_scene({2, 2, 2, 10.0});
  const auto degree = GENERATE(3, 5);
  FemOptions options;
  options.quadrature_degree = degree;
  FemModel pointwise(scene, options);
  const Vec3 slope(0.03, 0.0, -0.02);
  std::vector<double> factors;
  for (int e = 0; e < pointwise.mesh().element_count(); ++e)
    for (int q = 0; q < pointwise.solid().points_per_element(); ++q)
      factors.push_back(std::exp(slope.dot(pointwise.solid().rest_of_point(e, q))));
  pointwise.solid().set_stiffness(factors);
  options.effects.push_back(fem_effect(stiffness_gradient_effect()));
  FemModel varying(scene, options);
  set_effect(varying, stiffness_gradient_effect(), std::vector<double>{slope.x(), slope.y(), slope.z()});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.3, 0.0, -2.0)), PadInput{}};
  const FemState one = solved(varying, pads), other = solved(pointwise, pads);
  // The rule of degree 3 has the mean of an element for all its points.
  CHECK((one.x - other.x).cwiseAbs().maxCoeff() < (degree == 3 ? 0.05 : 1e-7));
  const Vec3 force = pad_forces(other, pads)[0];
  CHECK((pad_forces(one, pads)[0] - force).norm() < (degree == 3 ? 0.02 : 1e-7) * force.norm());
}

TEST_CASE("stiffness-gradient: derivatives, neutral numbers, words", "[effects]") {
  const std::vector<Chosen> chosen{{"slope.x", 0.02}, {"slope.z", -0.03}};
  check_derivatives(stiffness_gradient_effect(), chosen);
  check_neutral(stiffness_gradient_effect(), 1e-12);
  check_words(stiffness_gradient_effect(), chosen);
}
