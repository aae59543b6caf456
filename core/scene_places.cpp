#include "core/scene_places.hpp"

#include <algorithm>
#include <cstdio>

namespace tissued::core {

namespace {

constexpr double kMarkerReach = 20.0;  // mm; markers may stand on stalks, further off is a wrong coordinate frame
constexpr double kStalk = 2.0;         // mm; nearer, it is the skin that is faceted, or the place that is not exact
constexpr double kTargetReach = 0.5;   // mm; a faceted skin cuts a little off a round body

std::string format_mm(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", value);
  return text;
}

// The facets a marker may be glued to: the whole boundary but what is held, pads included.
std::vector<Triangle> marker_facets(const Scene& scene) {
  std::vector<Triangle> facets;
  if (const SurfaceGroup* skin = scene.mesh.find_surface(scene.skin_surface)) facets = skin->triangles;
  for (const Pad& pad : scene.pads)
    if (const SurfaceGroup* group = scene.mesh.find_surface(pad.surface))
      facets.insert(facets.end(), group->triangles.begin(), group->triangles.end());
  return facets.empty() ? boundary_of(scene.mesh) : facets;
}

// The tetrahedron behind a facet.
const Tet& behind(const TetMesh& mesh, const MaterialPoint& point) {
  const auto has = [](const Tet& tet, int node) { return std::find(tet.begin(), tet.end(), node) != tet.end(); };
  return *std::find_if(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
    return std::all_of(point.nodes.begin(), point.nodes.begin() + point.count,
                       [&](int node) { return has(tet, node); });
  });
}

MaterialPoint on_stalk(const TetMesh& mesh, const MaterialPoint& foot, const Vec3& position) {
  const Tet& tet = behind(mesh, foot);
  MaterialPoint point{tet, barycentric_in(mesh, tet, position), 4, foot.distance};
  const std::array<double, 4> below = barycentric_in(mesh, tet, rest_position(mesh, foot));
  for (std::size_t k = 0; k < 4; ++k) point.stalk[k] = point.weights[k] - below[k];
  return point;
}

}  // namespace

void check_scene(const Scene& scene) {
  const Material& m = scene.material;
  if (!(m.youngs_modulus > 0)) throw ModelError("material.youngs_modulus must be above 0 kPa");
  if (!(m.poissons_ratio > -1 && m.poissons_ratio < 0.5))
    throw ModelError("material.poissons_ratio must be in (-1, 0.5)");
  if (!(m.density > 0)) throw ModelError("material.density must be above 0 g/cm3");
  if (!scene.gravity.allFinite()) throw ModelError("gravity must be finite");
  if (scene.mesh.tets.empty()) throw ModelError("the mesh holds no tetrahedra");
  for (std::size_t i = 0; i < scene.mesh.tets.size(); ++i)
    if (!(signed_volume(scene.mesh, scene.mesh.tets[i]) > 0))
      throw ModelError("tetrahedron " + std::to_string(i) + " (from 0) is inverted or flat");
}

const SurfaceGroup& surface_of(const TetMesh& mesh, const std::string& name, const std::string& what) {
  const SurfaceGroup* group = mesh.find_surface(name);
  if (group == nullptr || group->triangles.empty())
    throw ModelError("the mesh has no surface group \"" + name + "\", which " + what + " needs");
  return *group;
}

std::vector<MaterialPoint> points_of_markers(const Scene& scene) {
  std::vector<MaterialPoint> points;
  if (scene.markers.empty()) return points;
  const std::vector<Triangle> facets = marker_facets(scene);
  for (const Marker& marker : scene.markers) {
    points.push_back(locate_on_surface(scene.mesh, facets, marker.rest));
    if (!(points.back().distance <= kMarkerReach))
      throw ModelError("marker " + marker.name + " is " + format_mm(points.back().distance) + " off the skin (limit " +
                       format_mm(kMarkerReach) + ")");
    if (points.back().distance > kStalk) points.back() = on_stalk(scene.mesh, points.back(), marker.rest);
  }
  return points;
}

std::vector<MaterialPoint> points_of_targets(const Scene& scene) {
  std::vector<MaterialPoint> points;
  for (const Target& target : scene.targets) {
    points.push_back(locate_in_volume(scene.mesh, target.rest));
    if (!(points.back().distance <= kTargetReach))
      throw ModelError("target " + target.name + " is " + format_mm(points.back().distance) +
                       " outside the mesh (limit " + format_mm(kTargetReach) + ")");
  }
  return points;
}

}  // namespace tissued::core
