#include "core/dense_kernels.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/dense_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tissued::core::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;

// y += s x
HWY_INLINE void add_scaled(int count, double s, const double* x, double* y) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V scale = hn::Set(d, s);
  int i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(hn::MulAdd(scale, hn::LoadU(d, x + i), hn::LoadU(d, y + i)), d, y + i);
  for (; i < count; ++i) y[i] += s * x[i];
}

double Dot(int count, const double* a, const double* b) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  V even = hn::Zero(d), odd = hn::Zero(d);
  int i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    even = hn::MulAdd(hn::LoadU(d, a + i), hn::LoadU(d, b + i), even);
    odd = hn::MulAdd(hn::LoadU(d, a + i + lanes), hn::LoadU(d, b + i + lanes), odd);
  }
  double sum = hn::GetLane(hn::SumOfLanes(d, even + odd));
  for (; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

// c[rows 0..3][0, width) += sum over k of a(row, k) b(k, .), where a(row, k) = a[row * row_stride + k * k_stride].
// Two vectors of four rows stay in registers; b's tile stays in the first-level cache over the rows.
template <int kRows>
HWY_INLINE void tile(int width, int depth, const double* a, std::ptrdiff_t row_stride, std::ptrdiff_t k_stride,
                     const double* b, std::ptrdiff_t b_stride, double* c, std::ptrdiff_t c_stride, double sign) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int j = 0;
  for (; j + 2 * lanes <= width; j += 2 * lanes) {
    V left[kRows], right[kRows];
    for (int row = 0; row < kRows; ++row) left[row] = right[row] = hn::Zero(d);
    for (int k = 0; k < depth; ++k) {
      const V b0 = hn::LoadU(d, b + k * b_stride + j), b1 = hn::LoadU(d, b + k * b_stride + j + lanes);
      for (int row = 0; row < kRows; ++row) {
        const V factor = hn::Set(d, a[row * row_stride + k * k_stride]);
        left[row] = hn::MulAdd(factor, b0, left[row]);
        right[row] = hn::MulAdd(factor, b1, right[row]);
      }
    }
    const V scale = hn::Set(d, sign);
    for (int row = 0; row < kRows; ++row) {
      double* out = c + row * c_stride + j;
      hn::StoreU(hn::MulAdd(scale, left[row], hn::LoadU(d, out)), d, out);
      hn::StoreU(hn::MulAdd(scale, right[row], hn::LoadU(d, out + lanes)), d, out + lanes);
    }
  }
  for (; j < width; ++j) {
    for (int row = 0; row < kRows; ++row) {
      double sum = 0.0;
      for (int k = 0; k < depth; ++k) sum += a[row * row_stride + k * k_stride] * b[k * b_stride + j];
      c[row * c_stride + j] += sign * sum;
    }
  }
}

// c (m x r) += sign a b with a(i, k) = a[i row_stride + k k_stride].
HWY_INLINE void product(int m, int depth, int r, const double* a, std::ptrdiff_t row_stride, std::ptrdiff_t k_stride,
                        const double* b, double* c, double sign) {
  constexpr int kWidth = 64, kDepth = 64;
  for (int j = 0; j < r; j += kWidth) {
    const int width = std::min(kWidth, r - j);
    for (int k = 0; k < depth; k += kDepth) {
      const int count = std::min(kDepth, depth - k);
      const double* b_tile = b + static_cast<std::ptrdiff_t>(k) * r + j;
      int i = 0;
      for (; i + 4 <= m; i += 4)
        tile<4>(width, count, a + i * row_stride + k * k_stride, row_stride, k_stride, b_tile, r,
                c + static_cast<std::ptrdiff_t>(i) * r + j, r, sign);
      for (; i < m; ++i)
        tile<1>(width, count, a + i * row_stride + k * k_stride, row_stride, k_stride, b_tile, r,
                c + static_cast<std::ptrdiff_t>(i) * r + j, r, sign);
    }
  }
}

void Multiply(int m, int k, int r, const double* a, const double* b, double* c) {
  std::fill(c, c + static_cast<std::ptrdiff_t>(m) * r, 0.0);
  product(m, k, r, a, k, 1, b, c, 1.0);
}

void AddProduct(int m, int k, int r, const double* a, const double* b, double* c) {
  product(m, k, r, a, k, 1, b, c, 1.0);
}

void AddRows(int count, int terms, const int* rows, const double* factors, const double* matrix, double* y) {
  for (int t = 0; t < terms; ++t)
    add_scaled(count, factors[t], matrix + static_cast<std::ptrdiff_t>(rows[t]) * count, y);
}

void SubtractTransposedProduct(int m, int p, int r, const double* a, const double* b, double* c) {
  product(p, m, r, a, 1, p, b, c, -1.0);
}

void ForwardSubstitute(int m, int r, const double* l, std::ptrdiff_t stride, double* y) {
  for (int i = 0; i < m; ++i) {
    double* row = y + static_cast<std::ptrdiff_t>(i) * r;
    for (int k = 0; k < i; ++k) add_scaled(r, -l[i + k * stride], y + static_cast<std::ptrdiff_t>(k) * r, row);
    const double inverse = 1.0 / l[i + i * stride];
    for (int j = 0; j < r; ++j) row[j] *= inverse;
  }
}

void BackwardSubstitute(int m, int r, const double* l, std::ptrdiff_t stride, double* y) {
  for (int i = m - 1; i >= 0; --i) {
    double* row = y + static_cast<std::ptrdiff_t>(i) * r;
    for (int k = i + 1; k < m; ++k) add_scaled(r, -l[k + i * stride], y + static_cast<std::ptrdiff_t>(k) * r, row);
    const double inverse = 1.0 / l[i + i * stride];
    for (int j = 0; j < r; ++j) row[j] *= inverse;
  }
}

// The tile (i0, j0) of all three blocks; crossed[i][j] = cross(j, i) before the predict.
constexpr int kTile = 32;

HWY_INLINE void predict_tile(int r, int i0, int j0, const double* a, const double* process_now,
                             const double* process_before, const double crossed[kTile][kTile], double* now,
                             double* cross, double* before) {
  const int rows = std::min(kTile, r - i0), columns = std::min(kTile, r - j0);
  for (int i = 0; i < rows; ++i) {
    const double ai = a[i0 + i];
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(i0 + i) * r + j0;
    for (int j = 0; j < columns; ++j) {
      const double p11 = now[at + j], p12 = cross[at + j], p21 = crossed[i][j], p22 = before[at + j];
      now[at + j] = ai * a[j0 + j] * (4.0 * p11 - 2.0 * (p12 + p21) + p22) + process_now[at + j];
      cross[at + j] = ai * (2.0 * p11 - p21);
      before[at + j] = p11 + process_before[at + j];
    }
  }
}

void PredictCovariance(int r, const double* a, const double* process_now, const double* process_before, double* now,
                       double* cross, double* before) {
  const auto transposed = [&](int i0, int j0, double out[kTile][kTile]) {
    const int rows = std::min(kTile, r - i0), columns = std::min(kTile, r - j0);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) out[i][j] = cross[static_cast<std::ptrdiff_t>(j0 + j) * r + i0 + i];
  };
  alignas(64) double upper[kTile][kTile], lower[kTile][kTile];
  for (int i0 = 0; i0 < r; i0 += kTile) {
    for (int j0 = i0; j0 < r; j0 += kTile) {
      transposed(i0, j0, upper);
      if (i0 == j0) {
        predict_tile(r, i0, i0, a, process_now, process_before, upper, now, cross, before);
        continue;
      }
      transposed(j0, i0, lower);
      predict_tile(r, i0, j0, a, process_now, process_before, upper, now, cross, before);
      predict_tile(r, j0, i0, a, process_now, process_before, lower, now, cross, before);
    }
  }
}

}  // namespace tissued::core::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tissued::core {

HWY_EXPORT(Dot);
HWY_EXPORT(Multiply);
HWY_EXPORT(AddProduct);
HWY_EXPORT(AddRows);
HWY_EXPORT(SubtractTransposedProduct);
HWY_EXPORT(ForwardSubstitute);
HWY_EXPORT(BackwardSubstitute);
HWY_EXPORT(PredictCovariance);

double dot(int count, const double* a, const double* b) { return HWY_DYNAMIC_DISPATCH(Dot)(count, a, b); }

void multiply(int m, int k, int r, const double* a, const double* b, double* c) {
  HWY_DYNAMIC_DISPATCH(Multiply)(m, k, r, a, b, c);
}

void add_product(int m, int k, int r, const double* a, const double* b, double* c) {
  HWY_DYNAMIC_DISPATCH(AddProduct)(m, k, r, a, b, c);
}

void add_rows(int count, int terms, const int* rows, const double* factors, const double* matrix, double* y) {
  HWY_DYNAMIC_DISPATCH(AddRows)(count, terms, rows, factors, matrix, y);
}

void subtract_transposed_product(int m, int p, int r, const double* a, const double* b, double* c) {
  HWY_DYNAMIC_DISPATCH(SubtractTransposedProduct)(m, p, r, a, b, c);
}

void forward_substitute(int m, int r, const double* l, std::ptrdiff_t stride, double* y) {
  HWY_DYNAMIC_DISPATCH(ForwardSubstitute)(m, r, l, stride, y);
}

void backward_substitute(int m, int r, const double* l, std::ptrdiff_t stride, double* y) {
  HWY_DYNAMIC_DISPATCH(BackwardSubstitute)(m, r, l, stride, y);
}

void predict_covariance(int r, const double* a, const double* process_now, const double* process_before, double* now,
                        double* cross, double* before) {
  HWY_DYNAMIC_DISPATCH(PredictCovariance)(r, a, process_now, process_before, now, cross, before);
}

}  // namespace tissued::core
#endif
