#include "tests/study/body.hpp"

#include <algorithm>
#include <array>
#include <set>

namespace tissued::study {

namespace {

using core::Tet;
using core::TetMesh;
using core::Triangle;
using core::Vec3;

// Cells of a grid over [-1, 1]^2 x [0, 1], x and y mirrored at 0: x and y counts are even.
struct Grid {
  int nx, ny, nz;

  int id(int i, int j, int k) const { return (k * (ny + 1) + j) * (nx + 1) + i; }
  Vec3 place(double i, double j, double k) const { return {2.0 * i / nx - 1.0, 2.0 * j / ny - 1.0, k / nz}; }
};

// Of random fineness; along each axis as fine as the body is long there.
Grid random_grid(const Vec3& size, Random& random) {
  const double cells =
      (random.chance(0.85) ? random.logarithmic(350.0, 700.0) : random.logarithmic(700.0, 1500.0)) / 6.0;
  const double edge = std::cbrt(size.prod() / cells);
  const auto even = [](double count) { return std::max(2, 2 * static_cast<int>(std::lround(0.5 * count))); };
  return {even(size.x() / edge), even(size.y() / edge), std::max(2, static_cast<int>(std::lround(size.z() / edge)))};
}

// Six tetrahedra for each cell, along the diagonal that leads away from the middle of the base: where the grid's edges
// are rounded off, no tetrahedron has two facets on the surface, and none becomes flat.
std::vector<Tet> cut(const Grid& grid) {
  std::vector<Tet> tets;
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const bool left = 2 * i < grid.nx, front = 2 * j < grid.ny;
        std::array<int, 3> axes{0, 1, 2};
        do {
          std::array<int, 3> at{0, 0, 0};
          Tet tet{};
          for (int step = 0; step < 4; ++step) {
            if (step > 0) at[axes[step - 1]] = 1;
            tet[step] = grid.id(i + (left ? 1 - at[0] : at[0]), j + (front ? 1 - at[1] : at[1]), k + at[2]);
          }
          tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return tets;
}

// From the grid's half cube to half a ball, or half a cylinder, of radius 1.
Vec3 shaped(const std::string& shape, const Vec3& p) {
  if (shape == "box") return p;
  const Vec3 across = shape == "loaf" ? Vec3(0.0, p.y(), p.z()) : p;
  const double norm = across.norm();
  if (norm < 1e-12) return p;
  Vec3 out = across * across.cwiseAbs().maxCoeff() / norm;
  if (shape == "loaf") out.x() = p.x();
  return out;
}

// A node moves within the faces of the grid that it lies on; corners and edges stay.
Vec3 jittered(const Grid& grid, int i, int j, int k, double jitter, Random& random) {
  const auto move = [&](int at, int count) {
    return at > 0 && at < count ? at + jitter * random.uniform(-1.0, 1.0) : at;
  };
  return grid.place(move(i, grid.nx), move(j, grid.ny), move(k, grid.nz));
}

void name_surfaces(TetMesh& mesh) {
  core::SurfaceGroup base{"base", {}}, skin{"skin", {}};
  for (const Triangle& facet : core::boundary_of(mesh)) {
    const bool low = std::all_of(facet.begin(), facet.end(), [&](int node) { return mesh.rest(node, 2) < 1e-9; });
    (low ? base : skin).triangles.push_back(facet);
  }
  mesh.surfaces = {base, skin};
}

Vec3 middle_of(const TetMesh& mesh, const Triangle& facet) {
  return (mesh.node(facet[0]) + mesh.node(facet[1]) + mesh.node(facet[2])) / 3.0;
}

}  // namespace

Body random_body(Random& random) {
  Body body;
  body.shape = std::array<std::string, 3>{"box", "dome", "loaf"}[static_cast<std::size_t>(random.integer(0, 2))];
  const double longest = random.uniform(40.0, 120.0);
  Vec3 size(longest, longest * random.uniform(0.6, 1.0), longest * random.uniform(0.35, 0.7));
  const Grid grid = random_grid(size, random);
  const double jitter = random.uniform(0.0, 0.2);
  TetMesh& mesh = body.mesh;
  mesh.tets = cut(grid);
  mesh.rest.resize((grid.nx + 1) * (grid.ny + 1) * (grid.nz + 1), 3);
  for (int k = 0; k <= grid.nz; ++k)
    for (int j = 0; j <= grid.ny; ++j)
      for (int i = 0; i <= grid.nx; ++i) {
        const Vec3 unit = shaped(body.shape, jittered(grid, i, j, k, jitter, random));
        mesh.rest.row(grid.id(i, j, k)) << 0.5 * size.x() * unit.x(), 0.5 * size.y() * unit.y(), size.z() * unit.z();
      }
  for (Tet& tet : mesh.tets)
    if (core::signed_volume(mesh, tet) < 0.0) std::swap(tet[2], tet[3]);
  name_surfaces(mesh);
  return body;
}

bool cut_patch(TetMesh& mesh, const std::string& name, const Vec3& middle, double radius) {
  std::set<int> taken;
  for (const core::SurfaceGroup& group : mesh.surfaces)
    if (group.name != "skin")
      for (const Triangle& facet : group.triangles) taken.insert(facet.begin(), facet.end());
  const auto skin = std::find_if(mesh.surfaces.begin(), mesh.surfaces.end(),
                                 [](const core::SurfaceGroup& group) { return group.name == "skin"; });
  core::SurfaceGroup patch{name, {}};
  std::vector<Triangle> rest;
  for (const Triangle& facet : skin->triangles)
    ((middle_of(mesh, facet) - middle).norm() < radius ? patch.triangles : rest).push_back(facet);
  const bool touches = std::any_of(patch.triangles.begin(), patch.triangles.end(), [&](const Triangle& facet) {
    return std::any_of(facet.begin(), facet.end(), [&](int node) { return taken.contains(node); });
  });
  if (patch.triangles.size() < 4 || touches) return false;
  skin->triangles = std::move(rest);
  mesh.surfaces.push_back(std::move(patch));
  return true;
}

}  // namespace tissued::study
