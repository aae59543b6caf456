// Effects in the real-time body: the very laws, fields and terms that the judge is made of, on ADMM's strain domains.
//
// Fields multiply the moduli of a domain, so that the local step minimises with them. Laws and terms are linearised
// ADMM: their force at the positions of the iteration enters the global step as it is. That converges as long as they
// are not stiffer than the ADMM weights, weight_scale times the body's stiffness. What is stiffer, springs that stand
// in for a support or a pad, holds its nodes exactly, in the directions in which it is stiff.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/effects/effect.hpp"
#include "core/effects/effect_setting.hpp"
#include "core/held_nodes.hpp"
#include "core/strain_domains.hpp"

namespace tissued::core {

class Enrichment {
 public:
  // Throws ModelError: a number out of its bounds, an effect given twice.
  Enrichment(const Scene& scene, std::span<const EffectSetting> effects);
  Enrichment(const Enrichment&) = delete;
  Enrichment& operator=(const Enrichment&) = delete;

  const Scene& scene() const { return scene_; }  // with the numbers that every simulator knows
  // What the moduli of a domain are multiplied with.
  double factor(const StrainDomain& domain) const;
  Eigen::VectorXd added_masses() const;  // (nodes) kg
  const RayleighDamping& damping() const { return damping_; }

  const std::vector<std::unique_ptr<FemLaw>>& laws() const { return physics_.laws; }
  const std::vector<std::unique_ptr<FemTerm>>& terms() const { return physics_.terms; }
  bool support_holds() const { return support_holds_; }  // false: only as its terms hold it
  bool pads_hold() const { return physics_.pads_hold; }  // likewise
  // Directions in which terms hold a node more stiffly than `limit`, mN/mm, all pads at rest.
  std::vector<HeldAxes> held_axes(std::span<const int> nodes, const Eigen::VectorXd& limit) const;

 private:
  Eigen::VectorXd rest() const;

  Scene scene_;
  FemMesh mesh_;  // linear tetrahedra
  FemPhysics physics_;
  RayleighDamping damping_;
  bool support_holds_;
};

}  // namespace tissued::core
