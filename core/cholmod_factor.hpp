// What every user of CHOLMOD needs of it. Included by sources only, so that nobody else sees its headers.
#pragma once

#include <cholmod.h>

#include <Eigen/Core>
#include <cstddef>

namespace tissued::core {

// Lower triangle by columns that somebody else owns.
cholmod_sparse lower_view(std::size_t size, std::size_t entries, const int* columns, const int* rows,
                          const double* values);

// A supernodal L L^T and the workspace it lives in.
struct CholmodFactor {
  mutable cholmod_common common;
  cholmod_factor* factor = nullptr;

  CholmodFactor();
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;
  ~CholmodFactor();

  // False where memory does not suffice.
  bool analyze(cholmod_sparse matrix);
  // False where the matrix is not positive definite. The same bits however many threads there are.
  bool factorize(cholmod_sparse matrix);
  // b (n x m) in the order of the matrix.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
};

}  // namespace tissued::core
