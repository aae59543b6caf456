// The laws and terms of an Enrichment while the simulation goes on: what they remember, and the forces they give now.
#pragma once

#include <vector>

#include "core/enrichment.hpp"
#include "core/model.hpp"

namespace tissued::core {

// Everything is sized at construction. The enrichment must outlive it; the model may be factored anew (same domains).
class EffectForces {
 public:
  EffectForces(const Enrichment& enrichment, const Model& model);

  void reset();  // back to rest: nothing is remembered
  // What is remembered now is what restore() goes back to.
  void keep() { kept_ = history_; }
  void restore();

  // F = Dx of every block; the local step writes it, see local_step.
  std::vector<PointDeformation>& deformations() { return deformations_; }

  // Stresses at deformations() and forces of terms at x. dt: s since the last accepted state.
  void evaluate(const Model& model, const std::vector<DomainState>& domains, const NodeField& x,
                std::span<const PadInput> pads, double dt, int threads);
  // Adds the stresses to the corners' forces, mN.
  void add_stresses(const Model& model, std::vector<CornerForce>& forces, int threads) const;
  // (n x 4) mN, of terms.
  const NodeField& node_forces() const { return node_forces_; }
  // The step is over: what is remembered follows on deformations() and x.
  void accept(const NodeField& x, std::span<const PadInput> pads, double dt, int threads);

  // Adds what terms press pads with, N, at x of the last evaluate.
  void add_pad_forces(std::span<const PadInput> pads, std::span<Vec3> forces) const;
  std::span<const double> history() const { return history_; }

 private:
  struct alignas(64) Stress {
    double p[9][kLanes];  // mN mm: first Piola-Kirchhoff times the domain's volume
  };
  std::size_t law_history(std::size_t law, int block) const;
  PointBatch batch_of(std::size_t law, int block, double dt) const;
  void evaluate_block(const Model& model, const DomainState& state, int block, double dt);
  void add_term(const FemTerm& term, const TermInput& input);
  void gather(const NodeField& x);

  const Enrichment* enrichment_;
  int blocks_;
  std::vector<std::size_t> law_offset_, term_offset_;  // into history_
  std::vector<double> history_, kept_;
  std::vector<PointDeformation> deformations_;  // (blocks)
  std::vector<Stress> stresses_;                // (blocks)
  NodeField node_forces_;
  Eigen::VectorXd x_;              // (3n) mm, as terms read positions
  std::vector<double> residuals_;  // of one term's entities
  std::vector<double> term_history_;
};

}  // namespace tissued::core
