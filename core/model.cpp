#include "core/model.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

const Scene& checked(const Scene& scene) {
  check_scene(scene);
  return scene;
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
