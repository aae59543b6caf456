// Geometry of the mesh against brute force on a box.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <map>

#include "core/mesh.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

double weight_sum(const MaterialPoint& point) {
  double sum = 0.0;
  for (double w : point.weights) sum += w;
  return sum;
}

// Distance to the facets by sampling each on a fine grid: from above, by at most half a grid step.
double sampled_distance(const TetMesh& mesh, const std::vector<Triangle>& facets, const Vec3& position, int grid) {
  double least = 1e300;
  for (const Triangle& t : facets) {
    for (int i = 0; i <= grid; ++i) {
      for (int j = 0; j <= grid - i; ++j) {
        const double u = static_cast<double>(i) / grid, v = static_cast<double>(j) / grid;
        const Vec3 sample = (1 - u - v) * mesh.node(t[0]) + u * mesh.node(t[1]) + v * mesh.node(t[2]);
        least = std::min(least, (sample - position).norm());
      }
    }
  }
  return least;
}

}  // namespace

TEST_CASE("a box is filled by its tetrahedra", "[mesh]") {
  const BoxSize size;
  const Scene scene = box_scene(size);
  double volume = 0.0;
  for (const Tet& tet : scene.mesh.tets) {
    CHECK(signed_volume(scene.mesh, tet) > 0);
    volume += signed_volume(scene.mesh, tet);
  }
  CHECK(volume == Approx(size.nx * size.ny * size.nz * 1e3));
}

TEST_CASE("the boundary of a box is closed and faces outwards", "[mesh]") {
  const BoxSize size;
  const Scene scene = box_scene(size);
  const std::vector<Triangle> boundary = boundary_of(scene.mesh);
  const int squares = 2 * (size.nx * size.ny + size.ny * size.nz + size.nx * size.nz);
  CHECK(boundary.size() == 2 * static_cast<std::size_t>(squares));
  std::map<std::pair<int, int>, int> edges;  // directed
  double volume = 0.0;
  for (const Triangle& t : boundary) {
    for (int a = 0; a < 3; ++a) ++edges[{t[a], t[(a + 1) % 3]}];
    volume += scene.mesh.node(t[0]).dot(scene.mesh.node(t[1]).cross(scene.mesh.node(t[2]))) / 6.0;
  }
  for (const auto& [edge, times] : edges) {
    CHECK(times == 1);
    CHECK(edges.count({edge.second, edge.first}) == 1);
  }
  CHECK(volume == Approx(size.nx * size.ny * size.nz * 1e3));  // divergence theorem: positive only when outward
}

TEST_CASE("nodes_of lists each node of a group once, ascending", "[mesh]") {
  const SurfaceGroup group{"g", {{5, 2, 9}, {9, 2, 1}}};
  CHECK(nodes_of(group) == std::vector<int>{1, 2, 5, 9});
}

TEST_CASE("locate_in_volume gives back a point inside and the nearest point outside", "[mesh]") {
  const BoxSize size{3, 2, 2, 10.0};
  const Scene scene = box_scene(size);
  const Vec3 extent(30, 20, 20);
  std::mt19937 generator(4);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 p = (0.5 * extent + 0.75 * extent.cwiseProduct(random_vector(generator)));
    const Vec3 nearest = p.cwiseMax(Vec3::Zero()).cwiseMin(extent);  // of a box, known
    const MaterialPoint point = locate_in_volume(scene.mesh, p);
    CHECK(weight_sum(point) == Approx(1.0));
    for (double w : point.weights) CHECK(w > -1e-8);
    CHECK((rest_position(scene.mesh, point) - nearest).norm() < 1e-8);
    CHECK(point.distance == Approx((p - nearest).norm()).margin(1e-8));
  }
}

TEST_CASE("locate_on_surface finds what sampling finds", "[mesh]") {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  // Facets in general position, so that corners, edges and insides of triangles are all met.
  TetMesh mesh;
  std::mt19937 generator(6);
  std::vector<Triangle> facets;
  mesh.rest.resize(18, 3);
  for (int i = 0; i < 18; ++i) mesh.rest.row(i) = 10.0 * random_vector(generator).transpose();
  for (int t = 0; t < 6; ++t) facets.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  int corners = 0, edges = 0, insides = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const Vec3 p = 14.0 * random_vector(generator);
    const MaterialPoint point = locate_on_surface(mesh, facets, p);
    const double sampled = sampled_distance(mesh, facets, p, 60);
    CHECK(point.distance <= sampled + 1e-9);
    CHECK(point.distance >= sampled - 0.35);  // the grid is at most 20 mm / 60 wide
    CHECK(weight_sum(point) == Approx(1.0));
    CHECK((rest_position(mesh, point) - p).norm() == Approx(point.distance));
    int zeros = 0;
    for (int a = 0; a < 3; ++a) zeros += point.weights[a] == 0.0;
    ++(zeros == 2 ? corners : zeros == 1 ? edges : insides);
  }
  CHECK(corners > 10);
  CHECK(edges > 10);
  CHECK(insides > 10);
  CHECK(scene.mesh.find_surface("base") != nullptr);
  CHECK(scene.mesh.find_surface("lid") == nullptr);
}
