#include "core/effects/skin.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("the skin of a box that is stretched without change of volume stores E h / 6 (I1 - 3) per area",
          "[effects]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({3, 2, 2, 10.0});
  constexpr double kStiffness = 40.0;
  // All faces but the support: top, two of each side.
  constexpr double kArea = 30.0 * 20.0 + 2.0 * 30.0 * 20.0 + 2.0 * 20.0 * 20.0;
  FemOptions options;
  options.element = element;
  const FemModel bare(scene, options);
  options.effects.push_back(fem_effect(skin_effect()));
  FemModel covered(scene, options);
  set_effect(covered, skin_effect(), std::vector<double>{kStiffness});
  FemEquilibrium with(covered, 1), without(bare, 1);
  const auto energy = [&](double stretch) {
    Eigen::VectorXd x = bare.rest(), forces;
    for (Eigen::Index i = 0; i < x.size(); i += 3) {
      x[i] *= stretch;
      x[i + 1] /= std::sqrt(stretch);
      x[i + 2] /= std::sqrt(stretch);
    }
    return with.terms(x, 0.0, rest_state(covered).history, forces) -
           without.terms(x, 0.0, rest_state(bare).history, forces);
  };
  for (const double stretch : {0.8, 1.0, 1.3}) {
    const double invariant = stretch * stretch + 2.0 / stretch;
    CHECK(energy(stretch) == Approx(kArea * kStiffness / 6.0 * (invariant - 3.0)).margin(1e-8));
  }
  constexpr double kSmall = 1e-3;
  CHECK((energy(1.0 + kSmall) + energy(1.0 - kSmall)) / (kSmall * kSmall) == Approx(kArea * kStiffness).epsilon(1e-4));
}

TEST_CASE("stretched to both sides, a sheet pulls with 2 E h times the strain", "[effects]") {
  // Of a box that is held at its sides: force across the middle from the energy's derivative.
  const Scene scene = box_scene({2, 2, 1, 10.0});
  FemOptions options;
  options.effects.push_back(fem_effect(skin_effect()));
  FemModel model(scene, options);
  FemEquilibrium equilibrium(model, 1);
  const auto energy = [&](double stiffness, double strain) {
    set_effect(model, skin_effect(), std::vector<double>{stiffness});
    Eigen::VectorXd x = model.rest(), forces;
    for (Eigen::Index i = 0; i < x.size(); i += 3) x.segment<2>(i) *= 1.0 + strain;
    return equilibrium.terms(x, 0.0, rest_state(model).history, forces);
  };
  constexpr double kSmall = 1e-4, kTop = 20.0 * 20.0, kSides = 4.0 * 20.0 * 10.0;
  const double sheet = (energy(30.0, kSmall) - energy(0.0, kSmall)) / (kSmall * kSmall);
  // Top: two strains, E h / (1 - nu) e^2; a side: one strain that may not narrow it, E h / (1 - nu^2) e^2 / 2.
  CHECK(sheet == Approx(30.0 * (2.0 * kTop + kSides / 1.5)).epsilon(2e-3));
}

TEST_CASE("skin: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(skin_effect(), {{"stiffness", 40.0}});
  check_neutral(skin_effect(), 1e-12);
  check_words(skin_effect(), {{"stiffness", 40.0}});
}
