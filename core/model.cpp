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

std::vector<StrainDomain> domains_of(const Scene& scene, Element element, double weight_scale, double time_step,
                                     const Enrichment* enrichment) {
  std::vector<StrainDomain> domains = strain_domains(scene.mesh, scene.material, element);
  if (enrichment == nullptr) return domains;
  // A damping stress is beta / dt times as stiff as the body, and the weights must be stiffer.
  const double damped = 1.0 + enrichment->damping().stiffness / (time_step * weight_scale);
  for (StrainDomain& domain : domains) {
    const double factor = enrichment->factor(domain);
    domain.shear_modulus *= factor;
    domain.bulk_modulus *= factor;
    domain.stiffness *= factor * damped;
  }
  return domains;
}

// With what drags: M (1 + alpha dt), so that the global step is as stiff as what it steps.
Eigen::VectorXd inertia_of(const Eigen::VectorXd& masses, double mass_damping, double time_step) {
  return mass_damping > 0.0 ? Eigen::VectorXd(masses * (1.0 + mass_damping * time_step)) : masses;
}

}  // namespace

// Nodes of a support or a pad that terms stand in for are held where the terms are stiffer than the ADMM weights, and
// left to the terms where they are not.
Model::Hold Model::hold_of(const Enrichment* enrichment) const {
  Hold hold{nodes_of(surface_of(scene_.mesh, scene_.fixed_surface, "the support")), pad_nodes_, {}};
  if (enrichment == nullptr || (enrichment->support_holds() && enrichment->pads_hold())) return hold;
  const Eigen::VectorXd weights = laplacian_.diagonal();
  hold.axes.resize(hold.groups.size());
  if (!enrichment->pads_hold())
    for (std::size_t p = 0; p < pad_nodes_.size(); ++p) hold.axes[p] = enrichment->held_axes(pad_nodes_[p], weights);
  if (enrichment->support_holds()) return hold;
  const std::vector<int> support = std::move(hold.fixed);
  const std::vector<HeldAxes> axes = enrichment->held_axes(support, weights);
  hold.fixed.clear();
  hold.groups.emplace_back();
  hold.axes.emplace_back();
  for (std::size_t k = 0; k < support.size(); ++k) {
    if (axes[k].count == 3) {
      hold.fixed.push_back(support[k]);
    } else {
      hold.groups.back().push_back(support[k]);
      hold.axes.back().push_back(axes[k]);
    }
  }
  return hold;
}

Model::Model(const Scene& scene, Element element, double weight_scale, double time_step, const Enrichment* enrichment)
    : scene_(checked(scene)),
      element_(element),
      weight_scale_(weight_scale),
      body_masses_(lumped_masses(scene_.mesh, scene_.material.density)),
      masses_(enrichment == nullptr ? body_masses_ : Eigen::VectorXd(body_masses_ + enrichment->added_masses())),
      mass_damping_(enrichment == nullptr ? 0.0 : enrichment->damping().mass),
      domains_(domains_of(scene_, element, weight_scale, time_step, enrichment)),
      blocks_(make_domain_blocks(domains_, weight_scale)),
      laplacian_(weighted_laplacian(scene_.mesh.node_count(), domains_, weight_scale)),
      pad_nodes_(nodes_of_pads(scene_)),
      pad_shares_(shares_of_pads(scene_, pad_nodes_)),
      hold_(hold_of(enrichment)),
      system_(laplacian_, blocks_, inertia_of(masses_, mass_damping_, time_step), hold_.fixed, time_step),
      holdable_(system_.factor(), system_.free_index(), hold_.groups, hold_.axes),
      contact_surface_(scene_, system_.factor(), system_.free_index()),
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
