#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/refined_mesh.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;

namespace {

std::vector<Vec3> middles_of_edges(const TetMesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const Tet& tet : mesh.tets)
    for (int a = 0; a < 4; ++a)
      for (int b = a + 1; b < 4; ++b) edges.insert(std::minmax(tet[a], tet[b]));
  std::vector<Vec3> middles;
  for (const auto& [a, b] : edges) middles.push_back(0.5 * (mesh.node(a) + mesh.node(b)));
  return middles;
}

}  // namespace

TEST_CASE("a body of flat faces is the same body in eight times as many elements", "[diagnosis]") {
  const Scene scene = testing::box_scene({});
  const TetMesh fine = refined(scene.mesh);
  CHECK(fine.tet_count() == 8 * scene.mesh.tet_count());
  double before = 0.0, after = 0.0;
  for (const Tet& tet : scene.mesh.tets) before += signed_volume(scene.mesh, tet);
  for (const Tet& tet : fine.tets) {
    CHECK(signed_volume(fine, tet) > 0.0);
    after += signed_volume(fine, tet);
  }
  CHECK(after == Approx(before));
  for (const SurfaceGroup& group : scene.mesh.surfaces)
    CHECK(fine.find_surface(group.name)->triangles.size() == 4 * group.triangles.size());
  const std::vector<Vec3> middles = middles_of_edges(scene.mesh);
  REQUIRE(fine.node_count() == scene.mesh.node_count() + static_cast<int>(middles.size()));
  for (int i = 0; i < fine.node_count(); ++i) {
    double nearest = i < scene.mesh.node_count() ? (fine.node(i) - scene.mesh.node(i)).norm() : 1.0;
    if (i >= scene.mesh.node_count())
      for (const Vec3& middle : middles) nearest = std::min(nearest, (fine.node(i) - middle).norm());
    CHECK(nearest < 1e-12);
  }
}

TEST_CASE("new nodes of a ball's surface lie nearer to the ball", "[diagnosis]") {
  // An icosahedron of tetrahedra around its middle, refined twice: all angles are gentle from the second time on.
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  TetMesh mesh;
  mesh.rest.resize(13, 3);
  mesh.rest << 0, 1, g, 0, -1, g, 0, 1, -g, 0, -1, -g, 1, g, 0, -1, g, 0, 1, -g, 0, -1, -g, 0, g, 0, 1, -g, 0, 1, g, 0,
      -1, -g, 0, -1, 0, 0, 0;
  mesh.rest *= 10.0 / std::sqrt(1.0 + g * g);
  mesh.surfaces = {{"skin", {}}};
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c) {
        const double edge = 20.0 / std::sqrt(1.0 + g * g) * 1.01;
        if ((mesh.node(a) - mesh.node(b)).norm() > edge || (mesh.node(b) - mesh.node(c)).norm() > edge ||
            (mesh.node(a) - mesh.node(c)).norm() > edge)
          continue;
        Tet tet{a, b, c, 12};
        if (signed_volume(mesh, tet) < 0.0) std::swap(tet[0], tet[1]);
        mesh.tets.push_back(tet);
        mesh.surfaces[0].triangles.push_back({tet[0], tet[1], tet[2]});
      }
  REQUIRE(mesh.tets.size() == 20);
  const TetMesh ball = refined(mesh), finer = refined(ball);
  const auto farthest = [](const TetMesh& body) {
    double most = 0.0;
    for (const Triangle& t : body.surfaces[0].triangles)
      for (int node : t) most = std::max(most, std::abs(10.0 - body.node(node).norm()));
    return most;
  };
  // Where the middles of the edges of the skin would be.
  double straight = 0.0;
  for (const Triangle& t : ball.surfaces[0].triangles)
    for (int k = 0; k < 3; ++k)
      straight = std::max(straight, std::abs(10.0 - (0.5 * (ball.node(t[k]) + ball.node(t[(k + 1) % 3]))).norm()));
  const double smooth = farthest(finer);
  CHECK(straight > 0.3);
  CHECK(smooth < 0.5 * straight);
}
