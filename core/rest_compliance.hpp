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

  // Three rows for each marker, then three for each target.
  int observed() const { return observed_; }
  // Pads that hold take their nodes out of play. Allocates nothing.
  void hold(std::span<const std::uint8_t> held_pads);
  // (3 free x observed) mm/mN under the pads held: what a unit force on a free node's axis does to what is observed.
  const RowMatrix& columns() const { return held_columns_; }

 private:
  int observed_ = 0;
  RowMatrix columns_;                 // (3 free x observed + pads): nothing held but the fixed nodes
  RowMatrix held_columns_;            // (3 free x observed)
  std::vector<int> pad_of_, row_of_;  // of every pad column: its pad, and its row
  RowMatrix reach_, work_;            // (most held x observed), (3 free x most held)
  Eigen::MatrixXd among_held_;
  std::vector<int> held_;
};

}  // namespace tissued::core
