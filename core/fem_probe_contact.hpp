// Probes that press on finite elements: unilateral contact without friction at the nodes of the skin, by an augmented
// Lagrangian. With phi the signed distance of node j to the probe and lambda_j its multiplier (mN) the energy is
//   sum_j (max(0, lambda_j - k_j phi)^2 - lambda_j^2) / (2 k_j);
// between solves lambda_j becomes max(0, lambda_j - k_j phi) until that changes nothing. (Bertsekas, Constrained
// Optimization and Lagrange Multiplier Methods, 1982, section 3.1.) In a solve the distance to the tangent plane stands
// for phi: a box is convex, so that -lambda phi lies below it and every solve brings the true energy down, while the
// probe's curvature in the tangent would make it indefinite.
#pragma once

#include <span>
#include <vector>

#include "core/fem_mesh.hpp"
#include "core/fem_term.hpp"
#include "core/probe_motion.hpp"
#include "core/scene.hpp"

namespace tissued::core {

class FemProbeContact final : public FemTerm {
 public:
  // fixed: ascending nodes that never move and need no contact. Scene and mesh outlive it. Throws ModelError where a
  // probe has friction.
  FemProbeContact(const Scene& scene, const FemMesh& mesh, const std::vector<int>& fixed);

  std::string_view name() const override { return "probes"; }
  int entity_count() const override { return static_cast<int>(multipliers_.size()); }
  int nodes_per_entity() const override { return 1; }
  std::span<const int> nodes_of_entity(int entity) const override { return {&nodes_[place_of(entity)], 1}; }
  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override;

  // No probe touches.
  void lift();
  // Moves the probes towards `inputs` (probes). x: (3n) mm. limit: see ProbeMotion. Returns mm by which they are ahead.
  double follow(std::span<const ProbeInput> inputs, const Eigen::VectorXd& x, double limit);
  // Nodes that pads hold (nonzero) are none of the contact's.
  void release(std::span<const std::uint8_t> held);
  // New multipliers at a solution x. Returns mm of contact that was still violated: penetration, or the gap under a
  // multiplier.
  double update(const Eigen::VectorXd& x);
  // As of the multipliers.
  int pressed() const;
  Vec3 force(int probe) const;                         // N, of the probe on the tissue
  double penetration(const Eigen::VectorXd& x) const;  // mm, at most

 private:
  std::size_t place_of(int entity) const { return static_cast<std::size_t>(entity) % nodes_.size(); }
  std::size_t probe_of(int entity) const { return static_cast<std::size_t>(entity) / nodes_.size(); }
  bool is_idle(int entity) const { return released_[place_of(entity)] != 0 || !motions_[probe_of(entity)].present(); }
  // In tissue coordinates.
  SignedDistance distance(int entity, const Eigen::VectorXd& x) const;
  void linearise(const Eigen::VectorXd& x);

  struct Plane {
    Vec3 normal = Vec3::UnitZ();  // unit, out of the probe
    double offset = 0.0;          // mm
    double distance(const Vec3& p) const { return normal.dot(p) + offset; }
  };

  std::span<const Probe> probes_;
  std::vector<int> nodes_;              // of the skin
  std::vector<double> stiffness_;       // (nodes) mN/mm, k_j
  std::vector<Vec3> outwards_;          // (nodes) unit, at rest
  std::vector<std::uint8_t> released_;  // (nodes)
  std::vector<ProbeMotion> motions_;    // (probes)
  std::vector<double> multipliers_;     // (probes x nodes) mN
  std::vector<Plane> planes_;           // (probes x nodes) where the last update was: what phi stands for
  std::vector<Vec3> pushes_;            // (probes x nodes) unit, of the multipliers
  std::vector<Vec3> at_;                // (nodes) mm
};

}  // namespace tissued::core
