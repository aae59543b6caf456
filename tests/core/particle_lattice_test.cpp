#include "core/particle_lattice.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("particles fill a box of whole cells exactly", "[pbd]") {
  const Scene scene = box_scene({4, 3, 2, 10.0});
  const ParticleLattice lattice(scene.mesh, 5.0);
  CHECK(lattice.count() == 8 * 6 * 4);
  CHECK((lattice.rest(0) - Vec3(2.5, 2.5, 2.5)).norm() < 1e-9);
  int on_surface = 0;
  for (int i = 0; i < lattice.count(); ++i) on_surface += lattice.on_surface(i) ? 1 : 0;
  CHECK(on_surface == 8 * 6 * 4 - 6 * 4 * 2);
}

TEST_CASE("the particles of a round body have its volume, and lie in it", "[pbd]") {
  // A box sheared and bent out of the lattice's directions: its volume is known from its tetrahedra.
  Scene scene = box_scene({6, 5, 4, 12.0});
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    const Vec3 p = scene.mesh.node(i);
    scene.mesh.rest.row(i) = Vec3(p.x() + 0.4 * p.z() + 0.003 * p.y() * p.y(), p.y() - 0.2 * p.x(), p.z()).transpose();
  }
  double volume = 0.0;
  for (const Tet& tet : scene.mesh.tets) volume += signed_volume(scene.mesh, tet);
  const double spacing = 3.0;
  const ParticleLattice lattice(scene.mesh, spacing);
  CHECK(lattice.count() * std::pow(spacing, 3) == Approx(volume).epsilon(0.01));
  for (int i = 0; i < lattice.count(); i += 17) CHECK(locate_in_volume(scene.mesh, lattice.rest(i)).distance < 1e-6);
}

TEST_CASE("neighbours in the lattice are those that a search over all finds", "[pbd]") {
  const ParticleLattice lattice(box_scene({4, 3, 2, 10.0}).mesh, 4.0);
  std::mt19937 generator(13);
  for (int trial = 0; trial < 30; ++trial) {
    const Vec3 center = Vec3(20, 15, 10) + 25.0 * random_vector(generator);
    const double radius = 8.0 + 7.0 * symmetric_random(generator);
    std::vector<int> all;
    int nearest = 0;
    for (int i = 0; i < lattice.count(); ++i) {
      if ((lattice.rest(i) - center).norm() <= radius) all.push_back(i);
      if ((lattice.rest(i) - center).norm() < (lattice.rest(nearest) - center).norm()) nearest = i;
    }
    CHECK(lattice.within(center, radius) == all);
    CHECK(lattice.nearest(center) == nearest);
  }
}

TEST_CASE("a spacing that makes no particles or far too many is refused with its value", "[pbd]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  CHECK_THROWS_WITH(ParticleLattice(scene.mesh, 0.01), Catch::Contains("particle_spacing 0.01"));
  // The middle of a single cell lies outside of this body: a tetrahedron in a corner of its box.
  TetMesh corner;
  corner.rest.resize(4, 3);
  corner.rest << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  corner.tets = {{0, 1, 2, 3}};
  CHECK_THROWS_WITH(ParticleLattice(corner, 10.0), Catch::Contains("no particle"));
}
