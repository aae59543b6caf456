// Which nodes of a body couple: the sparsity of every matrix of it, fixed once.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/fem_term.hpp"

namespace tissued::core {

// A symmetric matrix on all nodes, lower triangle, three rows and columns a node, compressed columns. Column 3j + c
// holds rows 3j + c to 3j + 2 of the diagonal block and then three rows for every further block of column j.
struct FemPattern {
  int node_count = 0;
  std::vector<int> block_begin;  // (nodes + 1) into block_row
  std::vector<int> block_row;    // row nodes of each column node, ascending; the diagonal first
  std::vector<int> column;       // (3 nodes + 1) into row and into values
  std::vector<int> row;          // (entries)

  std::size_t entries() const { return row.size(); }
  // Index into block_row of block (row, column), row >= column, which must exist.
  int block(int row_node, int column_node) const;
  // Where entry (0, c) of a block begins in values; the rows follow one another. Of a diagonal block: entry (c, c).
  int entry(int column_node, int block, int c) const;

  // y = A x; x (3 nodes).
  void multiply(const std::vector<double>& values, const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
};

FemPattern make_fem_pattern(int node_count, const std::vector<std::unique_ptr<FemTerm>>& terms);

}  // namespace tissued::core
