// The tangent of the free nodes, factored: one symbolic factorisation for all contact sets and all iterations. Nodes
// that are never free (the base) are left out; nodes that a pad holds stay in as rows of the identity.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "core/fem_pattern.hpp"

namespace tissued::core {

class FemFactor {
 public:
  // excluded: (nodes) nonzero where a node never moves freely. Throws ModelError where no node is left.
  FemFactor(const FemPattern& pattern, const std::vector<std::uint8_t>& excluded);
  ~FemFactor();
  FemFactor(FemFactor&&) noexcept;
  FemFactor& operator=(FemFactor&&) noexcept;

  // values: of the pattern; held: (nodes), including the excluded ones. False where the matrix is not positive definite
  // (or not finite): then nothing can be solved until the next factorisation that succeeds.
  // shift: share of the mean diagonal that is added to the diagonal.
  bool factorize(const std::vector<double>& values, const std::vector<std::uint8_t>& held, double shift = 0.0);
  bool ready() const;

  // K_ff^-1 b on free nodes, zero on held ones; b, x: (3 nodes x columns).
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

  int rows() const;
  double entries() const;  // of the factor
  double flops() const;    // of a factorisation

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tissued::core
