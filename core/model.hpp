// Everything of a run that does not change: the scene and what is computed from it once.
#pragma once

#include <vector>

#include "core/contact_surface.hpp"
#include "core/domain_blocks.hpp"
#include "core/enrichment.hpp"
#include "core/global_step.hpp"
#include "core/held_nodes.hpp"
#include "core/simulator.hpp"

namespace tissued::core {

class Model {
 public:
  // Throws ModelError: group missing, marker far from the skin, target outside the body, numbers out of range.
  // time_step: s, of the factor; kQuasiStatic for none. enrichment: of the same scene; outlives the model.
  Model(const Scene& scene, Element element, double weight_scale, double time_step,
        const Enrichment* enrichment = nullptr);

  const Scene& scene() const { return scene_; }
  double time_step() const { return system_.time_step(); }
  double weight_scale() const { return weight_scale_; }
  const Eigen::VectorXd& masses() const { return masses_; }  // (n) kg, of all that moves
  // (n) kg, without what effects attach: the weight of that is a term of theirs.
  const Eigen::VectorXd& body_masses() const { return body_masses_; }
  double mass_damping() const { return mass_damping_; }  // 1/s
  Element element() const { return element_; }
  const std::vector<StrainDomain>& domains() const { return domains_; }
  const DomainBlocks& blocks() const { return blocks_; }
  const SparseMatrix& laplacian() const { return laplacian_; }  // L on all nodes, lower triangle
  const GlobalSystem& system() const { return system_; }
  // Groups: pads; after them, where effects leave it partly loose, the support.
  const HoldableNodes& holdable() const { return holdable_; }
  const ContactSurface& contact_surface() const { return contact_surface_; }  // that probes may touch
  const std::vector<std::vector<int>>& pad_nodes() const { return pad_nodes_; }
  const std::vector<std::vector<double>>& pad_shares() const { return pad_shares_; }  // of a pad's force, by facet area
  const std::vector<MaterialPoint>& marker_points() const { return marker_points_; }
  const std::vector<MaterialPoint>& target_points() const { return target_points_; }
  const NodeField& rest() const { return rest_; }  // (n x 4) mm
  Eigen::Vector4d acceleration() const;            // mm/s2, of gravity

 private:
  // What holds the body.
  struct Hold {
    std::vector<int> fixed;                   // nodes, ascending
    std::vector<std::vector<int>> groups;     // nodes that are held and released together
    std::vector<std::vector<HeldAxes>> axes;  // beside them; empty: all
  };
  Hold hold_of(const Enrichment* enrichment) const;

  Scene scene_;
  Element element_;
  double weight_scale_;
  Eigen::VectorXd body_masses_, masses_;
  double mass_damping_;
  std::vector<StrainDomain> domains_;
  DomainBlocks blocks_;
  SparseMatrix laplacian_;
  std::vector<std::vector<int>> pad_nodes_;
  std::vector<std::vector<double>> pad_shares_;
  Hold hold_;
  GlobalSystem system_;
  HoldableNodes holdable_;
  ContactSurface contact_surface_;
  std::vector<MaterialPoint> marker_points_, target_points_;
  NodeField rest_;
};

// sum_a weight_a x_a, without what a marker on a stalk is off the skin.
Vec3 position_of(const MaterialPoint& point, const NodeField& x);

}  // namespace tissued::core
