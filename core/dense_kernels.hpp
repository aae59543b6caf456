// The dense arithmetic of the covariance, vectorised for every instruction set. Matrices are row-major with r columns
// unless said otherwise; nothing allocates.
#pragma once

#include <cstddef>

namespace tissued::core {

double dot(int count, const double* a, const double* b);

// c (m x r) = a (m x k) b (k x r)
void multiply(int m, int k, int r, const double* a, const double* b, double* c);

// c (m x r) += a (m x k) b (k x r)
void add_product(int m, int k, int r, const double* a, const double* b, double* c);

// y (count) += sum over t of factors[t] times row rows[t] of the matrix (any x count)
void add_rows(int count, int terms, const int* rows, const double* factors, const double* matrix, double* y);

// c (p x r) -= a^T b; a (m x p), b (m x r)
void subtract_transposed_product(int m, int p, int r, const double* a, const double* b, double* c);

// y (m x r) <- L^-1 y and L^-T y; L lower triangular, column-major with the given stride.
void forward_substitute(int m, int r, const double* l, std::ptrdiff_t stride, double* y);
void backward_substitute(int m, int r, const double* l, std::ptrdiff_t stride, double* y);

// One covariance predict (16) with S = [2A, -A; I, 0], A = diag(a); all matrices (r x r).
void predict_covariance(int r, const double* a, const double* process_now, const double* process_before, double* now,
                        double* cross, double* before);

}  // namespace tissued::core
