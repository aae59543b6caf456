// Triangular solves with four interleaved right-hand sides, compiled once for every instruction set.
#include "core/sparse_cholesky.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/supernodal_solve.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tissued::core::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Row = hn::FixedTag<float, 4>;  // one node's x, y, z, 0
using V = hn::Vec<Row>;

// Solves with the triangle of a panel; x are the panel's rows.
HWY_INLINE void forward_triangle(const float* l, int columns, float* x) {
  const Row d;
  for (int row = 0; row < columns; ++row) {
    V a = hn::LoadU(d, x + 4 * row), b = hn::Zero(d);
    const float* entry = l + static_cast<std::ptrdiff_t>(row) * columns;
    int c = 0;
    for (; c + 1 < row; c += 2) {
      a = hn::NegMulAdd(hn::Set(d, entry[c]), hn::LoadU(d, x + 4 * c), a);
      b = hn::NegMulAdd(hn::Set(d, entry[c + 1]), hn::LoadU(d, x + 4 * c + 4), b);
    }
    if (c < row) a = hn::NegMulAdd(hn::Set(d, entry[c]), hn::LoadU(d, x + 4 * c), a);
    hn::StoreU((a + b) * hn::Set(d, entry[row]), d, x + 4 * row);
  }
}

HWY_INLINE void backward_triangle(const float* l, int columns, float* x) {
  const Row d;
  for (int row = columns - 1; row >= 0; --row) {
    const float* entry = l + static_cast<std::ptrdiff_t>(row) * columns;
    const V value = hn::LoadU(d, x + 4 * row) * hn::Set(d, entry[row]);
    hn::StoreU(value, d, x + 4 * row);
    for (int c = 0; c < row; ++c)
      hn::StoreU(hn::NegMulAdd(hn::Set(d, entry[c]), value, hn::LoadU(d, x + 4 * c)), d, x + 4 * c);
  }
}

// x[rows] -= L_below x[panel]: four rows at a time hide the latency of the chained multiply-adds.
HWY_INLINE void forward_below(const float* l, const std::int32_t* rows, int count, int columns, const float* panel,
                              float* x) {
  const Row d;
  int r = 0;
  for (; r + 3 < count; r += 4) {
    const float* l0 = l + static_cast<std::ptrdiff_t>(r) * columns;
    const float *l1 = l0 + columns, *l2 = l1 + columns, *l3 = l2 + columns;
    float *x0 = x + 4 * rows[r], *x1 = x + 4 * rows[r + 1], *x2 = x + 4 * rows[r + 2], *x3 = x + 4 * rows[r + 3];
    V a0 = hn::LoadU(d, x0), a1 = hn::LoadU(d, x1), a2 = hn::LoadU(d, x2), a3 = hn::LoadU(d, x3);
    for (int c = 0; c < columns; ++c) {
      const V value = hn::LoadU(d, panel + 4 * c);
      a0 = hn::NegMulAdd(hn::Set(d, l0[c]), value, a0);
      a1 = hn::NegMulAdd(hn::Set(d, l1[c]), value, a1);
      a2 = hn::NegMulAdd(hn::Set(d, l2[c]), value, a2);
      a3 = hn::NegMulAdd(hn::Set(d, l3[c]), value, a3);
    }
    hn::StoreU(a0, d, x0);
    hn::StoreU(a1, d, x1);
    hn::StoreU(a2, d, x2);
    hn::StoreU(a3, d, x3);
  }
  for (; r < count; ++r) {
    const float* l0 = l + static_cast<std::ptrdiff_t>(r) * columns;
    float* x0 = x + 4 * rows[r];
    V a0 = hn::LoadU(d, x0);
    for (int c = 0; c < columns; ++c) a0 = hn::NegMulAdd(hn::Set(d, l0[c]), hn::LoadU(d, panel + 4 * c), a0);
    hn::StoreU(a0, d, x0);
  }
}

// x[panel] -= L_below^T x[rows], eight columns at a time in registers.
HWY_INLINE void backward_below(const float* l, const std::int32_t* rows, int count, int columns, float* panel,
                               const float* x) {
  const Row d;
  int c = 0;
  for (; c + 7 < columns; c += 8) {
    V a[8];
    for (int i = 0; i < 8; ++i) a[i] = hn::LoadU(d, panel + 4 * (c + i));
    for (int r = 0; r < count; ++r) {
      const V value = hn::LoadU(d, x + 4 * rows[r]);
      const float* entry = l + static_cast<std::ptrdiff_t>(r) * columns + c;
      for (int i = 0; i < 8; ++i) a[i] = hn::NegMulAdd(hn::Set(d, entry[i]), value, a[i]);
    }
    for (int i = 0; i < 8; ++i) hn::StoreU(a[i], d, panel + 4 * (c + i));
  }
  for (; c < columns; ++c) {
    V even = hn::LoadU(d, panel + 4 * c), odd = hn::Zero(d);
    int r = 0;
    for (; r + 1 < count; r += 2) {
      const float* entry = l + static_cast<std::ptrdiff_t>(r) * columns + c;
      even = hn::NegMulAdd(hn::Set(d, entry[0]), hn::LoadU(d, x + 4 * rows[r]), even);
      odd = hn::NegMulAdd(hn::Set(d, entry[columns]), hn::LoadU(d, x + 4 * rows[r + 1]), odd);
    }
    if (r < count)
      even = hn::NegMulAdd(hn::Set(d, l[static_cast<std::ptrdiff_t>(r) * columns + c]), hn::LoadU(d, x + 4 * rows[r]),
                           even);
    hn::StoreU(even + odd, d, panel + 4 * c);
  }
}

void SolvePanels(const SupernodalPanels& factor, float* x) {
  for (const SupernodalPanels::Panel& p : factor.panels) {
    float* panel = x + 4 * static_cast<std::ptrdiff_t>(p.first_column);
    forward_triangle(factor.values.data() + p.triangle, p.columns, panel);
    forward_below(factor.values.data() + p.below, factor.rows.data() + p.row_list, p.rows, p.columns, panel, x);
  }
  for (auto p = factor.panels.rbegin(); p != factor.panels.rend(); ++p) {
    float* panel = x + 4 * static_cast<std::ptrdiff_t>(p->first_column);
    backward_below(factor.values.data() + p->below, factor.rows.data() + p->row_list, p->rows, p->columns, panel, x);
    backward_triangle(factor.values.data() + p->triangle, p->columns, panel);
  }
}

}  // namespace tissued::core::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tissued::core {
HWY_EXPORT(SolvePanels);
void SupernodalPanels::solve(float* x) const { HWY_DYNAMIC_DISPATCH(SolvePanels)(*this, x); }
}  // namespace tissued::core
#endif
