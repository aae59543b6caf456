#include "core/effects/anisotropy.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/effects/effect_checks.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("fibres answer with the derivative of k/2 (I4bar - 1)^2 along them and across, pulled and pressed",
          "[effects]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  constexpr double k = 5.0;
  const MaterialPointTwin none(anisotropy_effect(), scene, {});
  const MaterialPointTwin along(anisotropy_effect(), scene, {{"k", k}, {"axis.x", -3.0}, {"axis.z", 0.0}});
  const MaterialPointTwin across(anisotropy_effect(), scene, {{"k", k}, {"axis.y", 0.1}, {"axis.z", 0.0}});
  for (const double stretch : {0.8, 1.1, 1.4}) {
    // A bar of constant volume: I4bar is stretch^2 along it, 1 / stretch across.
    const Mat3 f = Vec3(stretch, 1.0 / std::sqrt(stretch), 1.0 / std::sqrt(stretch)).asDiagonal();
    const double thinner = -0.5 * std::pow(stretch, -1.5);
    const Mat3 way = Vec3(1.0, thinner, thinner).asDiagonal();
    const auto work = [&](const MaterialPointTwin& point) {
      return (point.stress(f, 0.0) - none.stress(f, 0.0)).cwiseProduct(way).sum();
    };
    CHECK(work(along) == Approx(2.0 * k * stretch * (stretch * stretch - 1.0)));
    CHECK(work(across) == Approx(-k * (1.0 / stretch - 1.0) / (stretch * stretch)));
  }
}

TEST_CASE("anisotropy: derivatives, neutral numbers, words", "[effects]") {
  check_derivatives(anisotropy_effect(), {{"k", 4.0}, {"axis.x", 0.5}});
  check_neutral(anisotropy_effect(), 1e-12);
  check_words(anisotropy_effect(), {{"k", 4.0}, {"axis.x", 0.5}});
}
