// The coordinates in which the filter's covariance predict is elementwise: L phi = lambda M phi on the free nodes.
#pragma once

#include <vector>

#include "core/global_step.hpp"

namespace tissued::core {

struct ModalBasis {
  Eigen::VectorXd lambda;  // (r) 1/s2, ascending
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
      shapes;             // (free x r) 1/sqrt(kg); Phi^T M Phi = I
  bool complete = false;  // r equals the number of free nodes

  int modes() const { return static_cast<int>(lambda.size()); }
};

// The `modes` lowest; 0 or more than there are: all. Throws ModelError where the iteration for a part of them fails.
// laplacian: L on all nodes, lower triangle.
ModalBasis modal_basis(const SparseMatrix& laplacian, const Eigen::VectorXd& masses, const std::vector<int>& free_nodes,
                       int modes);

}  // namespace tissued::core
