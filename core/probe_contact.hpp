// Unilateral contact of the skin with probes, found anew in every step and solved without a new factor.
//
// Each global step asks for the least change of the body, in the norm of K, that leaves every sample j outside of the
// probe: phi(x_j) + n_j . delta_j >= 0, force f_j = lambda n_j + t_j with lambda >= 0, |t_j| <= friction lambda. K is
// one scalar matrix for three axes, so the Schur complement is A_jk I whatever the normals are: they are taken anew in
// every iteration, A once a step. Pads that hold are eliminated from A: both are exact at once. The forces are found by
// projected Gauss-Seidel on the samples' force vectors, beginning with those of the iteration before.
#pragma once

#include <span>
#include <vector>

#include "core/contact_surface.hpp"
#include "core/held_nodes.hpp"
#include "core/probe_motion.hpp"

namespace tissued::core {

// Mutable; allocates at construction only.
class ProbeContact {
 public:
  // The surface and the probes outlive it. most_held: nodes that pads hold, at most.
  ProbeContact(const ContactSurface& surface, std::span<const Probe> probes, int most_held);

  // As before the first step: no probe touches.
  void forget();
  // Moves the probes to where `inputs` (probes) say and finds the samples that may touch in this step. limit: see
  // ProbeMotion. held: the nodes that pads hold now. Returns mm by which the furthest tracked probe is ahead.
  double begin(std::span<const ProbeInput> inputs, const NodeField& x, const HeldNodes& held, double limit);

  // No sample is near a probe: there is nothing to solve for.
  bool empty() const { return candidates_.empty(); }
  // residual: (free x 4) mN in the factor's order. Adds the contact forces of the last iteration.
  void add_forces(float* residual) const;
  // x: where the linearisation is; delta: (free x 4) mm in the factor's order, the move without a change of contact.
  // Finds the forces that are needed and overwrites `change` (free x 4) with by how much they changed, mN. False where
  // nothing changed.
  bool solve(const NodeField& x, const float* delta, std::span<float> change);

  // mm: how deep the skin is in a probe, at most. 0 where nowhere.
  double penetration(const NodeField& x) const;
  int pressed() const;          // candidates with a force
  Vec3 force(int probe) const;  // N, of the probe on the tissue
  // mm: how far the furthest sample that a probe presses is from its place at rest.
  double travel(const NodeField& x, const NodeField& rest) const;

 private:
  struct Candidate {
    int sample, probe;
    double distance = 0.0;                             // mm, when it was chosen
    double gap = 0.0;                                  // mm, signed distance at the linearisation
    Eigen::Vector4d normal = Eigen::Vector4d::Zero();  // there
    Eigen::Vector4d offset = Eigen::Vector4d::Zero();  // mm, there, from the place of the probe that it stood at before
    Eigen::Vector4d anchor = Eigen::Vector4d::Zero();  // mm, where that place is now
  };
  void choose(double reach, const HeldNodes& held);
  void fill_compliance(const HeldNodes& held);
  void linearise(const NodeField& x);
  double relax(int j);
  Eigen::Vector4d& force_of(const Candidate& c) { return forces_[index_of(c)]; }
  const Eigen::Vector4d& force_of(const Candidate& c) const { return forces_[index_of(c)]; }
  std::size_t index_of(const Candidate& c) const {
    return static_cast<std::size_t>(c.probe) * surface_->samples().size() + static_cast<std::size_t>(c.sample);
  }

  const ContactSurface* surface_;
  std::span<const Probe> probes_;
  std::vector<ProbeMotion> motions_;     // (probes)
  std::vector<Vec3> at_, outwards_;      // (samples) mm, when the step began; unit, at rest
  std::vector<Eigen::Vector4d> forces_;  // (probes x samples) mN, of the probe on the tissue
  std::vector<Eigen::Vector4d> before_;  // (candidates) mN, when the iteration began
  std::vector<Candidate> candidates_;
  Eigen::MatrixXd compliance_;  // leading square: A, mm/mN, pads eliminated
  Eigen::MatrixXd resisted_;    // (held x candidates), see HeldNodes::resist
  NodeField moves_;             // (candidates x 4) mm
};

}  // namespace tissued::core
