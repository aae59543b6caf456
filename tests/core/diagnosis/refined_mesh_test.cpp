#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "core/refined_mesh.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;

TEST_CASE("a body of flat faces is the same body in eight times as many elements", "[diagnosis]") {
  const Scene scene = testing::box_scene({});
  const RefinedMesh fine = refined(scene.mesh);
  CHECK(fine.mesh.tet_count() == 8 * scene.mesh.tet_count());
  double before = 0.0, after = 0.0;
  for (const Tet& tet : scene.mesh.tets) before += signed_volume(scene.mesh, tet);
  for (const Tet& tet : fine.mesh.tets) {
    CHECK(signed_volume(fine.mesh, tet) > 0.0);
    after += signed_volume(fine.mesh, tet);
  }
  CHECK(after == Approx(before));
  for (const SurfaceGroup& group : scene.mesh.surfaces)
    CHECK(fine.mesh.find_surface(group.name)->triangles.size() == 4 * group.triangles.size());
  for (int i = 0; i < fine.mesh.node_count(); ++i)
    CHECK((fine.mesh.node(i) - 0.5 * (scene.mesh.node(fine.ends[i][0]) + scene.mesh.node(fine.ends[i][1]))).norm() <
          1e-12);
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
  TetMesh ball = refined(mesh).mesh;
  const RefinedMesh finer = refined(ball);
  double straight = 0.0, smooth = 0.0;
  for (int i = ball.node_count(); i < finer.mesh.node_count(); ++i) {
    const Vec3 a = ball.node(finer.ends[i][0]), b = ball.node(finer.ends[i][1]);
    if (a.norm() < 7.0 || b.norm() < 7.0) continue;  // an edge inside of the ball
    straight = std::max(straight, std::abs(10.0 - (0.5 * (a + b)).norm()));
    smooth = std::max(smooth, std::abs(10.0 - finer.mesh.node(i).norm()));
  }
  CHECK(straight > 0.3);
  CHECK(smooth < 0.5 * straight);
}
