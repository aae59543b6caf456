#include <catch2/catch.hpp>
#include <random>

#include "core/probe.hpp"

using namespace tissued::core;

namespace {

const ProbeShape kShape{Vec3(1.0, -2.0, 3.0), Vec3(20.0, 8.0, 30.0), 3.0};

// The least distance to a point of a dense sample of the box without its rounding, less the rounding: outside of it.
double sampled_distance(const ProbeShape& shape, const Vec3& p) {
  const Vec3 inner = shape.half_extents.array() - shape.rounding;
  double least = 1e9;
  for (int axis = 0; axis < 3; ++axis)
    for (double side : {-1.0, 1.0})
      for (int i = 0; i <= 200; ++i)
        for (int k = 0; k <= 200; ++k) {
          Vec3 q;
          q[axis] = side * inner[axis];
          q[(axis + 1) % 3] = inner[(axis + 1) % 3] * (0.01 * i - 1.0);
          q[(axis + 2) % 3] = inner[(axis + 2) % 3] * (0.01 * k - 1.0);
          least = std::min(least, (p - shape.center - q).norm());
        }
  return least - shape.rounding;
}

}  // namespace

TEST_CASE("the distance to a probe is that to its rounded box", "[probe]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> spread(-50.0, 50.0);
  for (int i = 0; i < 40; ++i) {
    const Vec3 p(spread(random), spread(random), spread(random));
    const SignedDistance found = signed_distance(kShape, p);
    if (found.distance > -kShape.rounding) CHECK(found.distance == Approx(sampled_distance(kShape, p)).margin(0.05));
    CHECK(found.normal.norm() == Approx(1.0));
  }
  CHECK(signed_distance(kShape, kShape.center).distance == Approx(-8.0));
  CHECK(signed_distance(kShape, kShape.center + Vec3(0.0, 0.0, 35.0)).distance == Approx(5.0));
}

TEST_CASE("the normal of a probe is its distance's gradient", "[probe]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> spread(-45.0, 45.0);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(spread(random), spread(random), spread(random));
    const SignedDistance at = signed_distance(kShape, p);
    Vec3 gradient;
    for (int axis = 0; axis < 3; ++axis)
      gradient[axis] = (signed_distance(kShape, p + 1e-6 * Vec3::Unit(axis)).distance -
                        signed_distance(kShape, p - 1e-6 * Vec3::Unit(axis)).distance) /
                       2e-6;
    CHECK((gradient - at.normal).norm() < 1e-4);
  }
}
