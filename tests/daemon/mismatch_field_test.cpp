#include "daemon/mismatch_field.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/daemon/diagnosis_samples.hpp"

using namespace tissued;
using core::Vec3;

namespace {

// A cube of `side` mm as six tetrahedra around its diagonal.
core::TetMesh cube(double side) {
  core::TetMesh mesh;
  mesh.rest.resize(8, 3);
  for (int i = 0; i < 8; ++i) mesh.rest.row(i) << side * (i & 1), side * ((i >> 1) & 1), side * (i >> 2);
  mesh.tets = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  for (const core::Tet& tet : mesh.tets) REQUIRE(core::signed_volume(mesh, tet) > 0.0);
  return mesh;
}

double sample(const daemon::MismatchGrid& grid, int i, int j, int k) {
  return grid.values[(static_cast<std::size_t>(k) * grid.size[1] + j) * static_cast<std::size_t>(grid.size[0]) + i];
}

}  // namespace

TEST_CASE("A map over tetrahedra becomes shares of the largest at nodes") {
  const core::TetMesh mesh = cube(10.0);
  CHECK(daemon::mismatch_at_nodes(mesh, std::vector(6, 0.25)) == std::vector(8, 1.0));
  // Node 1 belongs to the first and the last tetrahedron, node 2 to neither, 0 and 7 to all; volumes are the same.
  const auto nodes = daemon::mismatch_at_nodes(mesh, {0.6, 0, 0, 0, 0, 0.6});
  CHECK(nodes[1] == 1.0);
  CHECK(nodes[2] == 0.0);
  CHECK(nodes[0] == Approx(1.0 / 3.0));
  CHECK(nodes[3] == Approx(0.5));
  CHECK(daemon::mismatch_peak(mesh, nodes) == Vec3(10, 0, 0));
}

TEST_CASE("A map that says nothing is none") {
  const core::TetMesh mesh = cube(10.0);
  CHECK(daemon::mismatch_at_nodes(mesh, {}).empty());
  CHECK(daemon::mismatch_at_nodes(mesh, {1, 2, 3}).empty());
  CHECK(daemon::mismatch_at_nodes(mesh, std::vector(6, 0.0)).empty());
  CHECK(daemon::mismatch_at_nodes(mesh, std::vector(6, std::nan(""))).empty());
  const auto nodes = daemon::mismatch_at_nodes(mesh, {NAN, INFINITY, -3.0, 0, 0, 0.5});
  REQUIRE(nodes.size() == 8);
  CHECK(std::ranges::all_of(nodes, [](double value) { return value >= 0.0 && value <= 1.0; }));
}

TEST_CASE("The grid samples a linear field exactly, and goes on a little beyond the skin") {
  const core::TetMesh mesh = cube(10.0);
  std::vector<double> nodes;
  for (int i = 0; i < 8; ++i) nodes.push_back(0.05 * mesh.rest(i, 0) + 0.03 * mesh.rest(i, 1) + 0.02 * mesh.rest(i, 2));
  const daemon::MismatchGrid grid = daemon::mismatch_grid(mesh, nodes, 10);
  REQUIRE(grid.spacing == 1.0);
  REQUIRE(grid.values.size() == static_cast<std::size_t>(grid.size[0]) * grid.size[1] * grid.size[2]);
  int inside = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 at = grid.origin + grid.spacing * Vec3(i, j, k);
        if (at.minCoeff() < 0.0 || at.maxCoeff() > 10.0) continue;
        ++inside;
        CHECK(sample(grid, i, j, k) == Approx(255.0 * at.dot(Vec3(0.05, 0.03, 0.02))).margin(0.51));
      }
    }
  }
  CHECK(inside == 11 * 11 * 11);
  CHECK(sample(grid, 13, 13, 13) > 240.0);  // 1 mm beyond the corner at which the field is 1
}

TEST_CASE("The grid of the demo phantom is brightest at the lump") {
  const core::Scene scene = daemon::demo_scene();
  const core::Diagnosis diagnosis = daemon::inclusion_sample(scene);
  const auto nodes = daemon::mismatch_at_nodes(scene.mesh, diagnosis.mismatch_map);
  const daemon::MismatchGrid grid = daemon::mismatch_grid(scene.mesh, nodes, 40);
  const auto brightest = std::ranges::max_element(grid.values) - grid.values.begin();
  const auto row = brightest / grid.size[0];
  const Vec3 at = grid.origin + grid.spacing * Vec3(static_cast<double>(brightest % grid.size[0]),
                                                    static_cast<double>(row % grid.size[1]),
                                                    static_cast<double>(row / grid.size[1]));
  CHECK((at - diagnosis.findings[0].where->center).norm() < 10.0);
}
