// Factors the global matrix once (CHOLMOD, METIS ordering) and solves with it many times, three right-hand sides at
// once.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

namespace tissued::core {

using SparseMatrix = Eigen::SparseMatrix<double>;

// The factor's panels in single precision, repacked by rows for solves with four interleaved columns. The global step
// works on differences, x += K^-1 (residual in double), so single precision costs no accuracy: only K^-1's is rounded.
struct SupernodalPanels {
  struct Panel {
    int first_column;  // of the factor
    int columns;
    int rows;               // below the triangle
    std::int64_t triangle;  // offset into values: columns x columns row-major, diagonal inverted
    std::int64_t below;     // offset into values: rows x columns row-major
    std::int64_t row_list;  // offset into rows
  };
  int size = 0;
  int largest_panel = 0;
  std::vector<Panel> panels;
  std::vector<float> values;
  std::vector<std::int32_t> rows;
  // Solves L L^T x = b in place; x: (size x 4) in the factor's order.
  void solve(float* x) const;
};

class SparseCholesky {
 public:
  // Symmetric positive definite (n x n); only the lower triangle is read. Throws ModelError where it is not definite.
  explicit SparseCholesky(const SparseMatrix& lower);
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  int size() const;
  // Row k of the factor is row order()[k] of the matrix.
  const std::vector<int>& order() const;
  std::int64_t entries() const;
  const SupernodalPanels& panels() const;
  // Set-up solves in double: b (n x m) in the order of the matrix.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace tissued::core
