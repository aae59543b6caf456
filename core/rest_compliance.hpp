// How markers and targets answer small forces on the body at rest, elastic in all three axes: the gain of whoever
// explains what they did.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/modal_covariance.hpp"
#include "core/model.hpp"

namespace tissued::core {

// The tangent of (11) at rest on the free nodes, (3 free x 3 free) mN/mm, lower triangle; three rows a node.
SparseMatrix rest_tangent(const Model& model);

class RestCompliance {
 public:
  // Throws ModelError where the body is not held.
  explicit RestCompliance(const Model& model);

  // Three columns for each marker, then three for each target.
  int observed() const { return observed_; }
  // Pads that hold take their nodes out of play. Allocates nothing.
  void hold(std::span<const std::uint8_t> held_pads);
  // (3 free x observed + 3 pads) under the pads held: mm/mN, what a unit force on a free node's axis does to what is
  // observed; then mm/mm, by what a pad that holds moves the node, which is also the share of that force that it bears.
  const RowMatrix& columns() const { return held_columns_; }
  // (3 pads x observed) mm/mm: what moving a pad that holds along an axis does; zero for the others.
  const RowMatrix& pad_shift() const { return pad_shift_; }

 private:
  int axis_of(int pad_column) const { return 3 * pad_of_[pad_column] + pad_column % 3; }  // of all pads' axes

  int observed_ = 0;
  RowMatrix columns_;  // (3 free x observed + pads): nothing held but the fixed nodes
  RowMatrix held_columns_;
  RowMatrix pad_shift_;
  std::vector<int> pad_of_, row_of_;  // of every pad column, three a node: its pad, and its row
  RowMatrix reach_, work_;            // (most held x observed + 3 pads), (3 free x most held)
  Eigen::MatrixXd among_held_;
  std::vector<int> held_;
};

}  // namespace tissued::core
