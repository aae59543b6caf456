// The local step, compiled once for every instruction set (Highway) and chosen at run time.
#include "core/domain_blocks.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/local_step.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After highway.h: it is written in terms of the current target's vectors.
#include "core/stretch_newton-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tissued::core::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;

struct Matrix {
  V m[9];  // row-major 3 x 3
  V& operator()(int i, int j) { return m[3 * i + j]; }
  const V& operator()(int i, int j) const { return m[3 * i + j]; }
};

HWY_INLINE V dot_columns(const Matrix& a, int p, int q) {
  return hn::MulAdd(a(2, p), a(2, q), hn::MulAdd(a(1, p), a(1, q), a(0, p) * a(0, q)));
}

// One rotation of the one-sided Jacobi method: makes columns p and q of B = A V orthogonal, keeps A = B V^T.
// Returns the squared cosine of the angle between the columns before it.
HWY_INLINE V jacobi_rotate(D d, Matrix& b, Matrix& v, int p, int q) {
  const V app = dot_columns(b, p, p), aqq = dot_columns(b, q, q), apq = dot_columns(b, p, q);
  const V tiny = hn::Set(d, 1e-280);
  const V difference = aqq - app, twice = apq + apq;
  // t = tan of the angle that annihilates apq, the smaller root.
  const V root = hn::Sqrt(hn::MulAdd(difference, difference, hn::MulAdd(twice, twice, tiny)));
  const V denominator = hn::CopySign(hn::Abs(difference) + root, difference);
  const V t = twice / denominator;
  const V c = hn::Set(d, 1.0) / hn::Sqrt(hn::MulAdd(t, t, hn::Set(d, 1.0)));
  const V s = c * t;
  for (int i = 0; i < 3; ++i) {
    const V bp = b(i, p), bq = b(i, q);
    b(i, p) = hn::NegMulAdd(s, bq, c * bp);
    b(i, q) = hn::MulAdd(s, bp, c * bq);
    const V vp = v(i, p), vq = v(i, q);
    v(i, p) = hn::NegMulAdd(s, vq, c * vp);
    v(i, q) = hn::MulAdd(s, vp, c * vq);
  }
  return apq * apq / hn::MulAdd(app, aqq, tiny);
}

// Swaps columns p and q where norm_p < norm_q; one column changes sign so that det V stays 1. The warm start goes
// along.
HWY_INLINE void order_columns(Matrix& b, Matrix& v, V stretch[3], V norm[3], int p, int q) {
  const auto swap = norm[p] < norm[q];
  for (int i = 0; i < 3; ++i) {
    const V bp = b(i, p), vp = v(i, p);
    b(i, p) = hn::IfThenElse(swap, b(i, q), bp);
    v(i, p) = hn::IfThenElse(swap, v(i, q), vp);
    b(i, q) = hn::IfThenElse(swap, hn::Neg(bp), b(i, q));
    v(i, q) = hn::IfThenElse(swap, hn::Neg(vp), v(i, q));
  }
  const V s = stretch[p], n = norm[p];
  stretch[p] = hn::IfThenElse(swap, stretch[q], s);
  stretch[q] = hn::IfThenElse(swap, s, stretch[q]);
  norm[p] = hn::IfThenElse(swap, norm[q], n);
  norm[q] = hn::IfThenElse(swap, n, norm[q]);
}

// Singular value decomposition A = U diag(sigma) V^T with U, V rotations: sigma[2] is the smallest and carries the sign
// of det A. On entry v holds the warm start, stretch the values that belong to its columns.
HWY_INLINE void rotation_svd(D d, const Matrix& a, Matrix& u, V sigma[3], Matrix& v, V stretch[3]) {
  Matrix b;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) b(i, j) = hn::MulAdd(a(i, 2), v(2, j), hn::MulAdd(a(i, 1), v(1, j), a(i, 0) * v(0, j)));
  // Convergence is quadratic: a sweep that met no angle above 1e-4 leaves none above 1e-8, far below the Newton's needs
  // of orthogonality; the next warm start continues from there.
  const V enough = hn::Set(d, 1e-8);
  for (int sweep = 0; sweep < 8; ++sweep) {
    V worst = jacobi_rotate(d, b, v, 0, 1);
    worst = hn::Max(worst, jacobi_rotate(d, b, v, 0, 2));
    worst = hn::Max(worst, jacobi_rotate(d, b, v, 1, 2));
    if (hn::AllTrue(d, worst < enough)) break;
  }
  V norm[3] = {dot_columns(b, 0, 0), dot_columns(b, 1, 1), dot_columns(b, 2, 2)};
  order_columns(b, v, stretch, norm, 0, 1);
  order_columns(b, v, stretch, norm, 1, 2);
  order_columns(b, v, stretch, norm, 0, 1);

  const V tiny = hn::Set(d, 1e-200), one = hn::Set(d, 1.0);
  sigma[0] = hn::Sqrt(norm[0]);
  const V inverse0 = one / hn::Max(sigma[0], tiny);
  for (int i = 0; i < 3; ++i) u(i, 0) = b(i, 0) * inverse0;
  const V overlap = hn::MulAdd(u(2, 0), b(2, 1), hn::MulAdd(u(1, 0), b(1, 1), u(0, 0) * b(0, 1)));
  for (int i = 0; i < 3; ++i) u(i, 1) = hn::NegMulAdd(overlap, u(i, 0), b(i, 1));
  sigma[1] = hn::Sqrt(hn::MulAdd(u(2, 1), u(2, 1), hn::MulAdd(u(1, 1), u(1, 1), u(0, 1) * u(0, 1))));
  const V inverse1 = one / hn::Max(sigma[1], tiny);
  for (int i = 0; i < 3; ++i) u(i, 1) = u(i, 1) * inverse1;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    u(i, 2) = hn::NegMulAdd(u(k, 0), u(j, 1), u(j, 0) * u(k, 1));
  }
  sigma[2] = hn::MulAdd(u(2, 2), b(2, 2), hn::MulAdd(u(1, 2), b(1, 2), u(0, 2) * b(0, 2)));
}

// Keeps rounding from wearing V down over millions of iterations: Gram-Schmidt, third column by the cross product.
HWY_INLINE void orthonormalise(D d, Matrix& v) {
  const V one = hn::Set(d, 1.0);
  const V inverse0 = one / hn::Sqrt(dot_columns(v, 0, 0));
  for (int i = 0; i < 3; ++i) v(i, 0) = v(i, 0) * inverse0;
  const V overlap = dot_columns(v, 0, 1);
  for (int i = 0; i < 3; ++i) v(i, 1) = hn::NegMulAdd(overlap, v(i, 0), v(i, 1));
  const V inverse1 = one / hn::Sqrt(dot_columns(v, 1, 1));
  for (int i = 0; i < 3; ++i) v(i, 1) = v(i, 1) * inverse1;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    v(i, 2) = hn::NegMulAdd(v(k, 0), v(j, 1), v(j, 0) * v(k, 1));
  }
}

// F = Dx of one block, row-major. Rows of x are copied first and turned afterwards: a gather for every coordinate costs
// several times as much.
HWY_INLINE void deformation_gradients(D d, const DomainBlock& block, const DomainCorner* corners, const double* x,
                                      double f[9][kLanes]) {
  constexpr std::int64_t kChunk = 16;
  alignas(64) double rows[kChunk][kLanes][4];
  for (std::int64_t first = 0; first < block.corner_count; first += kChunk) {
    const std::int64_t last = std::min(first + kChunk, block.corner_count);
    for (std::int64_t a = first; a < last; ++a)
      for (int lane = 0; lane < kLanes; ++lane)
        std::memcpy(rows[a - first][lane], x + corners[a].row[lane], sizeof rows[0][0]);
    for (int lane = 0; lane < kLanes; lane += static_cast<int>(hn::Lanes(d))) {
      Matrix sum;
      for (int i = 0; i < 9; ++i) sum.m[i] = first == 0 ? hn::Zero(d) : hn::Load(d, &f[i][lane]);
      for (std::int64_t a = first; a < last; ++a) {
        V position[3], unused;
        hn::LoadInterleaved4(d, rows[a - first][lane], position[0], position[1], position[2], unused);
        for (int j = 0; j < 3; ++j) {
          const V gradient = hn::Load(d, &corners[a].gradient[j][lane]);
          for (int i = 0; i < 3; ++i) sum(i, j) = hn::MulAdd(position[i], gradient, sum(i, j));
        }
      }
      for (int i = 0; i < 9; ++i) hn::Store(sum.m[i], d, &f[i][lane]);
    }
  }
}

HWY_INLINE V determinant(const Matrix& a) {
  return a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) - a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
         a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0));
}

HWY_INLINE void store_corner_forces(D d, const DomainBlock& block, const DomainCorner* corners, const Matrix& f,
                                    const Matrix& z, const Matrix& u, int lane, CornerForce* out) {
  const V scale = hn::Neg(hn::Load(d, &block.stiffness[lane]) * hn::Load(d, &block.volume[lane]));
  Matrix h;
  for (int i = 0; i < 9; ++i) h.m[i] = scale * (f.m[i] - z.m[i] + u.m[i]);
  V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (std::int64_t a = 1; a < block.corner_count; ++a) {
    const V g0 = hn::Load(d, &corners[a].gradient[0][lane]), g1 = hn::Load(d, &corners[a].gradient[1][lane]),
            g2 = hn::Load(d, &corners[a].gradient[2][lane]);
    for (int i = 0; i < 3; ++i) {
      const V force = hn::MulAdd(h(i, 2), g2, hn::MulAdd(h(i, 1), g1, h(i, 0) * g0));
      hn::Store(force, d, &out[a].force[i][lane]);
      sum[i] = sum[i] + force;
    }
  }
  for (int i = 0; i < 3; ++i) hn::Store(hn::Neg(sum[i]), d, &out[0].force[i][lane]);
}

LocalStepResult LocalStep(const DomainBlocks& blocks, int first, int last, const double* x, DomainState* states,
                          CornerForce* forces, PointDeformation* deformations) {
  const D d;
  V primal = hn::Zero(d);
  LocalStepResult result;
  for (int index = first; index < last; ++index) {
    const DomainBlock& block = blocks.blocks[index];
    const DomainCorner* corners = &blocks.corners[static_cast<std::size_t>(block.first_corner)];
    DomainState& state = states[index];
    alignas(64) double gradients[9][kLanes];
    deformation_gradients(d, block, corners, x, gradients);
    if (deformations != nullptr) std::memcpy(deformations[index].f, gradients, sizeof gradients);
    for (int lane = 0; lane < kLanes; lane += static_cast<int>(hn::Lanes(d))) {
      Matrix f, p, v, u;
      for (int i = 0; i < 9; ++i) {
        f.m[i] = hn::Load(d, &gradients[i][lane]);
        p.m[i] = f.m[i] + hn::Load(d, &state.u[i][lane]);
        v.m[i] = hn::Load(d, &state.v[i][lane]);
      }
      V sigma[3], stretch[3];
      for (int i = 0; i < 3; ++i) stretch[i] = hn::Load(d, &state.stretch[i][lane]);
      rotation_svd(d, p, u, sigma, v, stretch);
      orthonormalise(d, v);
      const V factor = hn::Load(d, &state.factor[lane]);
      const NeoHookeanStretch energy{factor * hn::Load(d, &block.shear_modulus[lane]),
                                     factor * hn::Load(d, &block.bulk_modulus[lane])};
      result.unconverged += minimise_stretches(d, energy, hn::Load(d, &block.stiffness[lane]), sigma, stretch);

      Matrix z, dual;
      V gap = hn::Zero(d);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          z(i, j) = hn::MulAdd(u(i, 2) * stretch[2], v(j, 2),
                               hn::MulAdd(u(i, 1) * stretch[1], v(j, 1), u(i, 0) * stretch[0] * v(j, 0)));
          dual(i, j) = p(i, j) - z(i, j);
          const V difference = f(i, j) - z(i, j);
          gap = hn::MulAdd(difference, difference, gap);
        }
      }
      primal = hn::Max(primal, hn::Sqrt(gap) * hn::Load(d, &block.length[lane]));
      // Repeated lanes have no volume and are not counted.
      const auto inverted = hn::And(determinant(f) <= hn::Zero(d), hn::Load(d, &block.volume[lane]) > hn::Zero(d));
      result.inverted += static_cast<int>(hn::CountTrue(d, inverted));
      for (int i = 0; i < 9; ++i) {
        hn::Store(dual.m[i], d, &state.u[i][lane]);
        hn::Store(v.m[i], d, &state.v[i][lane]);
      }
      for (int i = 0; i < 3; ++i) hn::Store(stretch[i], d, &state.stretch[i][lane]);
      store_corner_forces(d, block, corners, f, z, dual, lane, forces + block.first_corner);
    }
  }
  result.primal = hn::GetLane(hn::MaxOfLanes(d, primal));
  return result;
}

}  // namespace tissued::core::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tissued::core {
HWY_EXPORT(LocalStep);
LocalStepResult local_step(const DomainBlocks& blocks, int first, int last, const double* x, DomainState* states,
                           CornerForce* forces, PointDeformation* deformations) {
  return HWY_DYNAMIC_DISPATCH(LocalStep)(blocks, first, last, x, states, forces, deformations);
}
}  // namespace tissued::core
#endif
