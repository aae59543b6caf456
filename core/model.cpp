#include "core/model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tissued::core {

namespace {

constexpr double kMarkerReach = 20.0;  // mm; markers may stand on stalks, further off is a wrong coordinate frame
constexpr double kTargetReach = 0.5;   // mm; a faceted skin cuts a little off a round body

std::string format_mm(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", value);
  return text;
}

const Scene& checked(const Scene& scene) {
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
  return scene;
}

const SurfaceGroup& surface_of(const TetMesh& mesh, const std::string& name, const std::string& what) {
  const SurfaceGroup* group = mesh.find_surface(name);
  if (group == nullptr || group->triangles.empty())
    throw ModelError("the mesh has no surface group \"" + name + "\", which " + what + " needs");
  return *group;
}

std::vector<std::vector<int>> nodes_of_pads(const Scene& scene) {
  std::vector<std::vector<int>> nodes;
  for (const Pad& pad : scene.pads) nodes.push_back(nodes_of(surface_of(scene.mesh, pad.surface, "pad " + pad.name)));
  return nodes;
}

// A pressed plate's force spread over its nodes by the area of their facets.
std::vector<std::vector<double>> shares_of_pads(const Scene& scene, const std::vector<std::vector<int>>& pad_nodes) {
  std::vector<std::vector<double>> shares;
  for (std::size_t p = 0; p < scene.pads.size(); ++p) {
    std::vector<double> share(pad_nodes[p].size(), 0.0);
    double total = 0.0;
    for (const Triangle& t : scene.mesh.find_surface(scene.pads[p].surface)->triangles) {
      const Vec3 a = scene.mesh.node(t[0]), b = scene.mesh.node(t[1]), c = scene.mesh.node(t[2]);
      const double third = (b - a).cross(c - a).norm() / 6.0;
      for (int node : t) {
        const auto at = std::lower_bound(pad_nodes[p].begin(), pad_nodes[p].end(), node);
        share[static_cast<std::size_t>(at - pad_nodes[p].begin())] += third;
      }
      total += 3.0 * third;
    }
    for (double& s : share) s /= total;
    shares.push_back(std::move(share));
  }
  return shares;
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

std::vector<MaterialPoint> points_of_markers(const Scene& scene) {
  std::vector<MaterialPoint> points;
  if (scene.markers.empty()) return points;
  const std::vector<Triangle> facets = marker_facets(scene);
  for (const Marker& marker : scene.markers) {
    points.push_back(locate_on_surface(scene.mesh, facets, marker.rest));
    if (!(points.back().distance <= kMarkerReach))
      throw ModelError("marker " + marker.name + " is " + format_mm(points.back().distance) + " off the skin (limit " +
                       format_mm(kMarkerReach) + ")");
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

}  // namespace

Model::Model(const Scene& scene, Element element, double weight_scale, double time_step)
    : scene_(checked(scene)),
      element_(element),
      weight_scale_(weight_scale),
      masses_(lumped_masses(scene_.mesh, scene_.material.density)),
      domains_(strain_domains(scene_.mesh, scene_.material, element)),
      blocks_(make_domain_blocks(domains_, weight_scale)),
      laplacian_(weighted_laplacian(scene_.mesh.node_count(), domains_, weight_scale)),
      fixed_nodes_(nodes_of(surface_of(scene_.mesh, scene_.fixed_surface, "the support"))),
      pad_nodes_(nodes_of_pads(scene_)),
      pad_shares_(shares_of_pads(scene_, pad_nodes_)),
      system_(laplacian_, blocks_, masses_, fixed_nodes_, time_step),
      holdable_(system_.factor(), system_.free_index(), pad_nodes_),
      marker_points_(points_of_markers(scene_)),
      target_points_(points_of_targets(scene_)),
      rest_(NodeField::Zero(scene_.mesh.node_count(), 4)) {
  rest_.leftCols<3>() = scene_.mesh.rest;
}

Eigen::Vector4d Model::acceleration() const {
  Eigen::Vector4d a = Eigen::Vector4d::Zero();
  a.head<3>() = scene_.gravity * kStandardGravity;
  return a;
}

Vec3 position_of(const MaterialPoint& point, const NodeField& x) {
  Eigen::Vector4d p = Eigen::Vector4d::Zero();
  for (int a = 0; a < 4; ++a) p += point.weights[a] * x.row(point.nodes[a]).transpose();
  return p.head<3>();
}

}  // namespace tissued::core
