#include "core/self_collision.hpp"

#include <catch2/catch.hpp>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

// A long bar, 3 particles thick, whose ends can be bent to each other.
struct Bar {
  ParticleLattice lattice{box_scene({12, 2, 1, 10.0}).mesh, 5.0};
  NodeField rest = NodeField::Zero(lattice.count(), 4);
  std::vector<double> free = std::vector<double>(static_cast<std::size_t>(lattice.count()), 1.0);
  Bar() {
    for (int i = 0; i < lattice.count(); ++i) rest.row(i).head<3>() = lattice.rest(i).transpose();
  }
  // Folded at x = 60, so that one half lies on the other, and a little too deep.
  NodeField folded(std::mt19937& generator) const {
    NodeField x = rest;
    for (int i = 0; i < lattice.count(); ++i) {
      if (x(i, 0) > 60.0) x.row(i) << 120.0 - x(i, 0), x(i, 1), x(i, 2) + 8.0, 0.0;
      x.row(i).head<3>() += random_vector(generator).transpose();
    }
    return x;
  }
};

}  // namespace

TEST_CASE("a body at rest does not collide with itself, not even when pressed together by a third", "[pbd]") {
  const Bar bar;
  SelfCollision collision(bar.lattice, 0.25);
  NodeField x = bar.rest;
  for (const double pressed : {1.0, 0.67}) {
    x = pressed * bar.rest;
    collision.find(x);
    collision.resolve(bar.free, bar.rest, x);
    CHECK(x == pressed * bar.rest);
  }
}

TEST_CASE("parts that meet are pushed apart, and momentum stays", "[pbd]") {
  const Bar bar;
  std::mt19937 generator(37);
  SelfCollision collision(bar.lattice, 0.25);
  NodeField x = bar.folded(generator);
  const NodeField before = x;
  // Every pair, by brute force: on the surface, strangers at rest, closer than a spacing now.
  const auto closest = [&](const NodeField& at) {
    double least = 1e9;
    for (int i = 0; i < bar.lattice.count(); ++i)
      for (int j = 0; j < i; ++j)
        if (bar.lattice.on_surface(i) && bar.lattice.on_surface(j) &&
            (bar.rest.row(i) - bar.rest.row(j)).norm() > 10.01)
          least = std::min(least, (at.row(i) - at.row(j)).norm());
    return least;
  };
  REQUIRE(closest(x) < 3.0);
  collision.find(x);
  for (int k = 0; k < 400; ++k) {
    if (k % 20 == 0) collision.find(x);
    collision.resolve(bar.free, x, x);
  }
  CHECK(closest(x) > 4.99);
  CHECK((x - before).colwise().sum().norm() < 1e-8);
}

TEST_CASE("a held particle stays, and the other takes the whole push", "[pbd]") {
  const Bar bar;
  SelfCollision collision(bar.lattice, 0.0);
  NodeField x = bar.rest;
  const int one = bar.lattice.nearest({2.5, 2.5, 2.5}), other = bar.lattice.nearest({117.5, 2.5, 2.5});
  x.row(other) = x.row(one) + Eigen::RowVector4d(-4.0, 0.0, 0.0, 0.0);
  const NodeField before = x;
  std::vector<double> mobility = bar.free;
  mobility[static_cast<std::size_t>(one)] = 0.0;
  collision.find(x);
  collision.resolve(mobility, before, x);
  CHECK(x.row(one) == before.row(one));
  CHECK((x.row(other) - before.row(one)).norm() == Approx(5.0));
}

TEST_CASE("friction between particles holds below the cone and slides above", "[pbd]") {
  const Bar bar;
  const double friction = 0.25;
  SelfCollision collision(bar.lattice, friction);
  const int one = bar.lattice.nearest({2.5, 2.5, 2.5}), other = bar.lattice.nearest({117.5, 2.5, 2.5});
  const double slide = GENERATE(0.2, 0.6);
  NodeField start = bar.rest;
  start.row(other) = start.row(one) + Eigen::RowVector4d(-6.0, 0.0, 0.0, 0.0);
  NodeField x = start;
  x.row(other) += Eigen::RowVector4d(2.0, slide, 0.0, 0.0);
  collision.find(x);
  collision.resolve(bar.free, start, x);
  const double left = std::abs((x.row(other) - start.row(other) - x.row(one) + start.row(one))(1));
  // The push is 1 mm and the cone 0.25; the line between the two is tilted by what slides, which adds little.
  if (slide < 0.25) {
    CHECK(left < 0.06);
  } else {
    CHECK(left == Approx(slide - friction).margin(0.25));
    CHECK(left > 0.3);
  }
}
