#include "tests/benchmark/block_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tissued::benchmark {

namespace {

constexpr double kLength = 150.0, kWidth = 100.0, kHeight = 60.0;

// The six tetrahedra of a cube along its main diagonal (Kuhn): corner bits are x, y, z.
constexpr std::array<std::array<int, 4>, 6> kKuhn{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

}  // namespace

core::Scene block_scene(int tets) {
  const double cell = std::cbrt(kLength * kWidth * kHeight / (tets / 6.0));
  const int nx = std::max(1, static_cast<int>(std::lround(kLength / cell)));
  const int ny = std::max(1, static_cast<int>(std::lround(kWidth / cell)));
  const int nz = std::max(1, static_cast<int>(std::lround(kHeight / cell)));
  const auto node = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  core::Scene scene;
  scene.name = "block";
  scene.mesh.rest.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        scene.mesh.rest.row(node(i, j, k)) =
            core::Vec3(kLength * (double(i) / nx - 0.5), kWidth * (double(j) / ny - 0.5), kHeight * double(k) / nz);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (const auto& tet : kKuhn) {
          core::Tet t;
          for (int a = 0; a < 4; ++a) t[a] = node(i + (tet[a] & 1), j + (tet[a] >> 1 & 1), k + (tet[a] >> 2));
          if (core::signed_volume(scene.mesh, t) < 0) std::swap(t[2], t[3]);
          scene.mesh.tets.push_back(t);
        }
  core::SurfaceGroup base{"base", {}}, skin{"skin", {}}, pad{"A1", {}};
  for (const core::Triangle& facet : core::boundary_of(scene.mesh)) {
    core::Vec3 middle = core::Vec3::Zero();
    for (int corner : facet) middle += scene.mesh.node(corner) / 3.0;
    const bool under_pad = middle.z() > kHeight - 1e-6 && std::max(std::abs(middle.x()), std::abs(middle.y())) < 15.0;
    (middle.z() < 1e-6 ? base : under_pad ? pad : skin).triangles.push_back(facet);
  }
  scene.mesh.surfaces = {base, skin, pad};
  scene.pads.push_back({"A1", "A1", core::Vec3(0, 0, kHeight), core::Vec3(0, 0, -1)});
  for (int m = 0; m < 19; ++m) {
    const double angle = 2.399963 * m, radius = 30.0 + 0.8 * m;  // golden angle: no two alike
    std::string name("M");
    name += std::to_string(m);
    scene.markers.push_back({name, {radius * std::cos(angle), radius * std::sin(angle), kHeight}});
  }
  scene.targets.push_back({"T1", {5.0, 3.0, 30.0}});
  return scene;
}

}  // namespace tissued::benchmark
