// Prescribed nodes, exact and without refactoring: whatever touches or leaves the body at run time holds its nodes by a
// Schur complement on precomputed columns of K^-1.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "core/sparse_cholesky.hpp"
#include "core/types.hpp"

namespace tissued::core {

// In which directions a node is held.
struct HeldAxes {
  Mat3 axes = Mat3::Identity();  // its first `count` columns, orthonormal
  int count = 3;
};

// How the nodes that may be held answer a unit force. Immutable; part of the model.
class HoldableNodes {
 public:
  // groups: nodes that are held and released together, a pad's. axes: beside the groups' nodes, in which directions at
  // rest they are held; empty: in all. Nodes without a row in the factor (free_index -1: fixed anyway) and those that
  // no axis holds are left out.
  HoldableNodes(const SparseCholesky& factor, const std::vector<int>& free_index,
                const std::vector<std::vector<int>>& groups, const std::vector<std::vector<HeldAxes>>& axes = {});

  int count() const { return static_cast<int>(node.size()); }
  int group_count() const { return group_count_; }
  bool slides() const { return slides_; }  // some node is not held in all directions

  // Of every holdable node:
  std::vector<int> node, group;
  std::vector<int> row;        // of the factor's order
  std::vector<HeldAxes> axes;  // at rest
  std::vector<float> columns;  // (free x count) row-major, mm/mN: K^-1, rows in the factor's order
  Eigen::MatrixXd compliance;  // (count x count) mm/mN

 private:
  int group_count_;
  bool slides_ = false;
};

// The set that is held now. Mutable; allocates at construction only.
class HeldNodes {
 public:
  explicit HeldNodes(const HoldableNodes& holdable);

  // Holds the groups whose flag is set, their axes turned by `rotations` (groups; empty: not turned); factors their
  // small dense matrix. A node of two held groups follows the first.
  void hold(std::span<const std::uint8_t> groups, std::span<const Mat3> rotations = {});

  int count() const { return count_; }
  int node(int k) const { return holdable_->node[held_[k]]; }
  int group(int k) const { return holdable_->group[held_[k]]; }
  int row(int k) const { return holdable_->row[held_[k]]; }
  bool slides() const { return holdable_->slides(); }
  bool holds(int row_of_factor) const {
    return std::any_of(held_.begin(), held_.begin() + count_,
                       [&](int held) { return holdable_->row[held] == row_of_factor; });
  }

  // What the hold takes of the compliance between other points: out (count) such that K^-1 between two of them is less
  // by out . out', on every axis. A point: rows of the factor's order (-1: none) and their weights. Not where some held
  // nodes slide.
  void resist(std::span<const int> rows, std::span<const double> weights, Eigen::Ref<Eigen::VectorXd> out) const;

  // Forgets the constraint forces (back to rest).
  void forget_forces();
  // residual: (free x 4) mN in the factor's order. Adds the constraint forces of the last step, so that in equilibrium
  // nothing is left to solve for and the rounding of the factor cancels out.
  void add_forces(float* residual) const;
  // delta: (free x 4) mm in the factor's order, K^-1 residual on entry. Adds what makes the k-th held node move by
  // wanted[k], along its axes.
  void enforce(float* delta, std::span<const Eigen::Vector4d> wanted);
  // mN, what holds the k-th held node where it is.
  const Eigen::Vector4d& force(int k) const { return forces_[held_[k]]; }
  // `from`, moved along the axes of the k-th held node to where it is level with `to`: `to` where it does not slide.
  Eigen::Vector4d level(int k, const Eigen::Vector4d& from, const Eigen::Vector4d& to) const;

 private:
  // One direction in which a held node is held.
  struct Constraint {
    int k;
    Vec3 axis;
  };
  void solve_constraints();

  const HoldableNodes* holdable_;
  // Leading square: Cholesky factor of the compliance of the held nodes; where some slide, of the constraints.
  Eigen::MatrixXd factor_;
  std::vector<int> held_;
  int count_ = 0;
  std::vector<Eigen::Vector4d> forces_;      // (holdable) mN; zero where not held
  std::vector<Eigen::Vector4d> increments_;  // (held) mN
  std::vector<float> increment_rows_;
  std::vector<Constraint> constraints_;  // where some slide
  std::vector<int> first_constraint_;    // (held + 1) likewise
  Eigen::VectorXd multipliers_;          // (constraints) mN
};

}  // namespace tissued::core
