#include "tests/core/test_bodies.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <numeric>

#include "core/effects/effect.hpp"

namespace tissued::core::testing {

double symmetric_random(std::mt19937& generator) {
  return 2.0 * static_cast<double>(generator()) / static_cast<double>(std::mt19937::max()) - 1.0;
}

Vec3 random_vector(std::mt19937& generator) {
  Vec3 v;
  for (double& entry : v) entry = symmetric_random(generator);
  return v;
}

Mat3 random_matrix(std::mt19937& generator) {
  Mat3 m;
  for (int i = 0; i < 3; ++i) m.col(i) = random_vector(generator);
  return m;
}

Mat3 random_rotation(std::mt19937& generator) {
  const Vec3 axis = random_vector(generator).normalized();
  return Eigen::AngleAxisd(3.14159 * symmetric_random(generator), axis).toRotationMatrix();
}

namespace {

TetMesh box_mesh(const BoxSize& size) {
  TetMesh mesh;
  const int px = size.nx + 1, py = size.ny + 1, pz = size.nz + 1;
  const auto id = [&](int i, int j, int k) { return (k * py + j) * px + i; };
  std::mt19937 generator(7);
  mesh.rest.resize(px * py * pz, 3);
  for (int k = 0; k < pz; ++k) {
    for (int j = 0; j < py; ++j) {
      for (int i = 0; i < px; ++i) {
        const bool inner = i > 0 && j > 0 && k > 0 && i < size.nx && j < size.ny && k < size.nz;
        Vec3 place = size.edge * Vec3(i, j, k);
        if (inner) place += 0.15 * size.edge * random_vector(generator);
        mesh.rest.row(id(i, j, k)) = place.transpose();
      }
    }
  }
  for (int k = 0; k < size.nz; ++k) {
    for (int j = 0; j < size.ny; ++j) {
      for (int i = 0; i < size.nx; ++i) {
        std::array<int, 3> axes{0, 1, 2};
        do {  // Kuhn: one tetrahedron for every order in which the axes are walked from corner to corner
          std::array<int, 3> at{i, j, k};
          Tet tet{};
          tet[0] = id(at[0], at[1], at[2]);
          for (int step = 0; step < 3; ++step) {
            ++at[axes[step]];
            tet[step + 1] = id(at[0], at[1], at[2]);
          }
          if (signed_volume(mesh, tet) < 0) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return mesh;
}

void name_surfaces(TetMesh& mesh, const BoxSize& size) {
  const double top = size.nz * size.edge, half = 0.5 * size.nx * size.edge, deep = (size.ny - 0.5) * size.edge;
  SurfaceGroup base{"base", {}}, skin{"skin", {}}, a1{"A1", {}}, a2{"A2", {}};
  for (const Triangle& facet : boundary_of(mesh)) {
    const Vec3 middle = (mesh.node(facet[0]) + mesh.node(facet[1]) + mesh.node(facet[2])) / 3.0;
    if (middle.z() < 1e-9) {
      base.triangles.push_back(facet);
    } else if (middle.z() > top - 1e-9 && middle.y() < deep - 0.5 * size.edge) {
      (middle.x() < half ? a1 : a2).triangles.push_back(facet);
    } else {
      skin.triangles.push_back(facet);
    }
  }
  mesh.surfaces = {base, skin, a1, a2};
}

Pad pad_on(const TetMesh& mesh, const std::string& name) {
  Pad pad{name, name, Vec3::Zero(), Vec3(0, 0, -1)};
  const std::vector<int> nodes = nodes_of(*mesh.find_surface(name));
  for (int node : nodes) pad.center += mesh.node(node) / static_cast<double>(nodes.size());
  return pad;
}

}  // namespace

Scene box_scene(const BoxSize& size, int markers) {
  Scene scene;
  scene.name = "box";
  scene.mesh = box_mesh(size);
  name_surfaces(scene.mesh, size);
  scene.pads = {pad_on(scene.mesh, "A1"), pad_on(scene.mesh, "A2")};
  std::mt19937 generator(11);
  const std::vector<Triangle>& skin = scene.mesh.find_surface("skin")->triangles;
  for (int m = 0; m < markers; ++m) {
    const Triangle& facet = skin[generator() % skin.size()];
    const Vec3 a = scene.mesh.node(facet[0]), b = scene.mesh.node(facet[1]), c = scene.mesh.node(facet[2]);
    const Vec3 place = 0.5 * a + 0.3 * b + 0.2 * c + 0.3 * (b - a).cross(c - a).normalized();
    scene.markers.push_back({std::string("m").append(std::to_string(m)), place});
  }
  const Vec3 extent = size.edge * Vec3(size.nx, size.ny, size.nz);
  for (int t = 0; t < 3; ++t)
    scene.targets.push_back(
        {std::string("T").append(std::to_string(t)), extent.cwiseProduct(Vec3(0.3 + 0.17 * t, 0.52, 0.71 - 0.13 * t))});
  return scene;
}

std::vector<EffectSetting> many_effects(const Scene& scene) {
  std::vector<EffectSetting> settings;
  for (const char* kind :
       {"viscoelasticity", "softening", "skin", "inclusion", "gravity", "loose-base", "sliding-actuator"}) {
    const Effect* effect = find_effect(kind);
    settings.push_back({effect, effect->starts(scene).front()});
  }
  settings[4].values = {0.0, 0.3, -0.3};
  return settings;
}

std::vector<int> shared_nodes(const TetMesh& mesh, const std::string& one, const std::string& other) {
  const std::vector<int> a = nodes_of(*mesh.find_surface(one)), b = nodes_of(*mesh.find_surface(other));
  std::vector<int> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

}  // namespace tissued::core::testing
