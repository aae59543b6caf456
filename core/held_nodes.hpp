// Prescribed nodes, exact and without refactoring: whatever touches or leaves the body at run time holds its nodes by a
// Schur complement on precomputed columns of K^-1.
#pragma once

#include <span>
#include <vector>

#include "core/sparse_cholesky.hpp"
#include "core/types.hpp"

namespace tissued::core {

// How the nodes that may be held answer a unit force. Immutable; part of the model.
class HoldableNodes {
 public:
  // groups: nodes that are held and released together, a pad's. Nodes without a row in the factor (free_index -1: fixed
  // anyway) are left out.
  HoldableNodes(const SparseCholesky& factor, const std::vector<int>& free_index,
                const std::vector<std::vector<int>>& groups);

  int count() const { return static_cast<int>(node.size()); }
  int group_count() const { return group_count_; }

  // Of every holdable node:
  std::vector<int> node, group;
  std::vector<int> row;        // of the factor's order
  std::vector<float> columns;  // (free x count) row-major, mm/mN: K^-1, rows in the factor's order
  Eigen::MatrixXd compliance;  // (count x count) mm/mN

 private:
  int group_count_;
};

// The set that is held now. Mutable; allocates at construction only.
class HeldNodes {
 public:
  explicit HeldNodes(const HoldableNodes& holdable);

  // Holds the groups whose flag is set; factors their small dense matrix. A node of two held groups follows the first.
  void hold(std::span<const std::uint8_t> groups);

  int count() const { return count_; }
  int node(int k) const { return holdable_->node[held_[k]]; }
  int group(int k) const { return holdable_->group[held_[k]]; }
  int row(int k) const { return holdable_->row[held_[k]]; }

  // Forgets the constraint forces (back to rest).
  void forget_forces();
  // residual: (free x 4) mN in the factor's order. Adds the constraint forces of the last step, so that in equilibrium
  // nothing is left to solve for and the rounding of the factor cancels out.
  void add_forces(float* residual) const;
  // delta: (free x 4) mm in the factor's order, K^-1 residual on entry. Adds what makes the k-th held node move by
  // wanted[k].
  void enforce(float* delta, std::span<const Eigen::Vector4d> wanted);
  // mN, what holds the k-th held node where it is.
  const Eigen::Vector4d& force(int k) const { return forces_[held_[k]]; }

 private:
  const HoldableNodes* holdable_;
  Eigen::MatrixXd factor_;  // leading (count x count): Cholesky factor of the compliance of the held nodes
  std::vector<int> held_;
  int count_ = 0;
  std::vector<Eigen::Vector4d> forces_;      // (holdable) mN; zero where not held
  std::vector<Eigen::Vector4d> increments_;  // (held) mN
  std::vector<float> increment_rows_;
};

}  // namespace tissued::core
