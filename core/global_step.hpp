// The global step (7): one scalar matrix K = M / dt^2 + L for all three axes, L = sum_i w_i^2 G_i^T G_i, factored once
// on the free nodes.
//
// Every solve is for a difference: K (x_new - x) = r with r = M (x_tilde - x) / dt^2 + f - D^T W^2 (Dx - z + u), which
// is equation (7) rearranged. The fixed point r = 0 therefore does not depend on how exactly K is inverted, nor on
// whether the inertia in r uses the same dt as K: a measured dt needs no new factor.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "core/domain_blocks.hpp"
#include "core/sparse_cholesky.hpp"

namespace tissued::core {

inline constexpr double kQuasiStatic = std::numeric_limits<double>::infinity();  // a time step without inertia

// kg, a quarter of each element's mass to each of its nodes.
Eigen::VectorXd lumped_masses(const TetMesh& mesh, double density);

// L on all nodes (n x n), kPa mm = mN/mm, lower triangle; k_i = weight_scale times the domain's stiffness.
SparseMatrix weighted_laplacian(int nodes, const std::vector<StrainDomain>& domains, double weight_scale);

// Rows and columns `nodes` (ascending) of a lower triangle.
SparseMatrix restrict_lower(const SparseMatrix& lower, const std::vector<int>& nodes);

class GlobalSystem {
 public:
  // laplacian: L on all nodes. The corners of `blocks` are what the rows of the residual are summed from.
  GlobalSystem(const SparseMatrix& laplacian, const DomainBlocks& blocks, const Eigen::VectorXd& masses,
               const std::vector<int>& fixed_nodes, double time_step);

  double time_step() const { return time_step_; }
  int free_count() const { return static_cast<int>(free_nodes_.size()); }
  const std::vector<int>& free_nodes() const { return free_nodes_; }
  const std::vector<int>& free_index() const { return free_index_; }  // (n) or -1
  const SparseCholesky& factor() const { return factor_; }
  // Mesh node of row k of the factor.
  int node_of_row(int k) const { return row_node_[k]; }
  // Offsets into the array of CornerForce, as doubles: x component; y and z follow after kLanes and 2 kLanes.
  std::span<const std::int64_t> incident(int row) const {
    return {incident_.data() + incident_begin_[row], incident_.data() + incident_begin_[row + 1]};
  }

 private:
  double time_step_;
  std::vector<int> free_nodes_, free_index_;
  SparseCholesky factor_;
  std::vector<int> row_node_;
  std::vector<std::int64_t> incident_;
  std::vector<std::int64_t> incident_begin_;
};

}  // namespace tissued::core
