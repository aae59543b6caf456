#include "core/skin_outline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

// All that is not held for good: the skin, and the pads' places where no pad holds.
std::vector<Triangle> facets_of(const Scene& scene) {
  std::vector<Triangle> facets = surface_of(scene.mesh, scene.skin_surface, "a probe").triangles;
  for (const Pad& pad : scene.pads) {
    const SurfaceGroup& group = surface_of(scene.mesh, pad.surface, "pad " + pad.name);
    facets.insert(facets.end(), group.triangles.begin(), group.triangles.end());
  }
  return facets;
}

}  // namespace

SkinOutline skin_outline(const Scene& scene) {
  SkinOutline outline;
  // Facets of a group may be turned either way; those of the boundary look outwards.
  std::map<Triangle, Vec3> normals;
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  for (const Triangle& t : boundary_of(scene.mesh)) {
    const Vec3 a = scene.mesh.node(t[0]);
    normals.emplace(sorted(t), (scene.mesh.node(t[1]) - a).cross(scene.mesh.node(t[2]) - a));
  }
  for (const Triangle& t : facets_of(scene)) {
    const auto found = normals.find(sorted(t));
    if (found == normals.end()) continue;  // inside the body
    for (int k = 0; k < 3; ++k) {
      outline.nodes.try_emplace(t[k], Vec3::Zero()).first->second += found->second;
      const std::array<int, 2> edge{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      outline.edges.try_emplace(edge, Vec3::Zero()).first->second += found->second;
    }
  }
  return outline;
}

}  // namespace tissued::core
