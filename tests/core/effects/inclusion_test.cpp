#include "core/effects/inclusion.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

const std::vector<Chosen> kLump{
    {"center.x", 12.0}, {"center.y", 9.0}, {"center.z", 11.0}, {"radius", 7.0}, {"ratio", 6.0}};

double inside(const Vec3& place) {
  // The smooth ball of radius 7 and width 1: r^3 + pi^2 r = 343.
  constexpr double kRadius = 6.530772137;
  return 1.0 / (1.0 + std::exp((place - Vec3(12.0, 9.0, 11.0)).norm() - kRadius));
}

}  // namespace

TEST_CASE("a lump answers as a body whose points were given its stiffness", "[effects]") {
  const Scene scene = box_scene({2, 2, 2, 10.0});
  FemOptions options;
  options.quadrature_degree = 5;  // all weights positive: the stiffness is that of the point
  FemModel pointwise(scene, options);
  std::vector<double> factors;
  for (int e = 0; e < pointwise.mesh().element_count(); ++e)
    for (int q = 0; q < pointwise.solid().points_per_element(); ++q)
      factors.push_back(std::pow(6.0, inside(pointwise.solid().rest_of_point(e, q))));
  pointwise.solid().set_stiffness(factors);
  options.effects.push_back(fem_effect(inclusion_effect()));
  FemModel lump(scene, options);
  set_effect(lump, inclusion_effect(), chosen_values(inclusion_effect(), scene, kLump));
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.3, 0.0, -2.0)), PadInput{}};
  const FemState one = solved(lump, pads), other = solved(pointwise, pads);
  CHECK((one.x - other.x).cwiseAbs().maxCoeff() < 1e-5);
  const Vec3 force = pad_forces(one, pads)[0];
  CHECK((force - pad_forces(other, pads)[0]).norm() < 1e-4 * force.norm());
  const FemModel plain(scene, {});
  CHECK((pad_forces(solved(plain, pads), pads)[0] - force).norm() > 0.03 * force.norm());

  // The usual rule, whose elements have one stiffness each.
  FemOptions usual;
  usual.effects.push_back(fem_effect(inclusion_effect()));
  FemModel elementwise(scene, usual);
  set_effect(elementwise, inclusion_effect(), chosen_values(inclusion_effect(), scene, kLump));
  CHECK((pad_forces(solved(elementwise, pads), pads)[0] - force).norm() < 0.15 * force.norm());
}

TEST_CASE("a lump weighs as much as a sharp ball of its radius", "[effects]") {
  for (const double radius : {4.0, 7.0, 20.0}) {
    FemPhysics physics;
    const Scene scene = box_scene({2, 2, 2, 10.0});
    inclusion_effect().add_to(scene, make_fem_mesh(scene.mesh, FemElement::p1), physics);
    FemField& field = *physics.fields.front();
    for (const auto& [index, value] :
         std::vector<std::pair<int, double>>{{0, 0.0}, {1, 0.0}, {2, 0.0}, {3, radius}, {4, 2.0}})
      field.set_parameter(index, value);
    double volume = 0.0;
    constexpr double kStep = 0.01;
    for (double r = 0.5 * kStep; r < 60.0; r += kStep)
      volume += kStep * 4.0 * M_PI * r * r * field.log_factor(Vec3(r, 0.0, 0.0)) / std::log(2.0);
    CHECK(volume == Approx(4.0 / 3.0 * M_PI * radius * radius * radius).epsilon(0.02));
  }
}

TEST_CASE("inclusion: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(inclusion_effect(), kLump);
  check_neutral(inclusion_effect(), 1e-12);
  check_words(inclusion_effect(), kLump);
}
