// The inner loops of FemSolid, compiled once for every instruction set (Highway) and chosen at run time.
#include "core/fem_solid.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/fem_solid_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tissued::core::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kPointLanes>;
using V = hn::Vec<D>;

// Gradients of the shape functions by rest position, (nodes x 3).
HWY_INLINE void shape_gradients(D d, const SolidBlock& block, const SolidPoint& point, std::size_t lane, V* gradients) {
  for (int axis = 0; axis < 3; ++axis) {
    V barycentric[4];
    for (int k = 0; k < 4; ++k) barycentric[k] = hn::Load(d, block.gradient[k][axis] + lane);
    for (int a = 0; a < point.nodes; ++a) {
      V sum = hn::Zero(d);
      for (int k = 0; k < 4; ++k)
        if (point.slope[a][k] != 0.0) sum = hn::MulAdd(hn::Set(d, point.slope[a][k]), barycentric[k], sum);
      gradients[3 * a + axis] = sum;
    }
  }
}

void Deformation(const SolidBlock& block, const SolidPoint& point, const double* corners,
                 PointDeformation& deformation) {
  const D d;
  V g[3 * kMostElementNodes];
  for (std::size_t lane = 0; lane < kPointLanes; lane += hn::Lanes(d)) {
    shape_gradients(d, block, point, lane, g);
    for (int i = 0; i < 3; ++i) {
      V f0 = hn::Zero(d), f1 = f0, f2 = f0;
      for (int a = 0; a < point.nodes; ++a) {
        const V x = hn::Load(d, corners + (3 * a + i) * kPointLanes + lane);
        f0 = hn::MulAdd(x, g[3 * a], f0);
        f1 = hn::MulAdd(x, g[3 * a + 1], f1);
        f2 = hn::MulAdd(x, g[3 * a + 2], f2);
      }
      hn::Store(f0, d, deformation.f[3 * i] + lane);
      hn::Store(f1, d, deformation.f[3 * i + 1] + lane);
      hn::Store(f2, d, deformation.f[3 * i + 2] + lane);
    }
  }
}

void AddResidual(const SolidBlock& block, const SolidPoint& point, const double (*stress)[kPointLanes],
                 double* residual) {
  const D d;
  V g[3 * kMostElementNodes];
  for (std::size_t lane = 0; lane < kPointLanes; lane += hn::Lanes(d)) {
    shape_gradients(d, block, point, lane, g);
    for (int i = 0; i < 3; ++i) {
      const V p0 = hn::Load(d, stress[3 * i] + lane), p1 = hn::Load(d, stress[3 * i + 1] + lane),
              p2 = hn::Load(d, stress[3 * i + 2] + lane);
      for (int a = 0; a < point.nodes; ++a) {
        double* entry = residual + (3 * a + i) * kPointLanes + lane;
        const V sum = hn::MulAdd(p0, g[3 * a], hn::MulAdd(p1, g[3 * a + 1], hn::Load(d, entry)));
        hn::Store(hn::MulAdd(p2, g[3 * a + 2], sum), d, entry);
      }
    }
  }
}

// Block (a, b) is sum_JL g_a[J] A_{iJ,jL} g_b[L]: first T = A g_b, then every a >= b.
void AddTangent(const SolidBlock& block, const SolidPoint& point, const double (*tangent)[kPointLanes],
                double* blocks) {
  const D d;
  V g[3 * kMostElementNodes];
  for (std::size_t lane = 0; lane < kPointLanes; lane += hn::Lanes(d)) {
    shape_gradients(d, block, point, lane, g);
    for (int b = 0; b < point.nodes; ++b) {
      V t[9][3];  // [iJ][j]
      for (int row = 0; row < 9; ++row) {
        for (int j = 0; j < 3; ++j) {
          V sum = hn::Zero(d);
          for (int axis = 0; axis < 3; ++axis) {
            const int column = 3 * j + axis;
            const int index = row >= column ? pair_index(row, column) : pair_index(column, row);
            sum = hn::MulAdd(hn::Load(d, tangent[index] + lane), g[3 * b + axis], sum);
          }
          t[row][j] = sum;
        }
      }
      for (int a = b; a < point.nodes; ++a) {
        double* entry = blocks + 9 * pair_index(a, b) * kPointLanes + lane;
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            double* at = entry + (3 * i + j) * kPointLanes;
            V sum = hn::MulAdd(g[3 * a], t[3 * i][j], hn::Load(d, at));
            sum = hn::MulAdd(g[3 * a + 1], t[3 * i + 1][j], sum);
            hn::Store(hn::MulAdd(g[3 * a + 2], t[3 * i + 2][j], sum), d, at);
          }
        }
      }
    }
  }
}

}  // namespace tissued::core::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tissued::core {
HWY_EXPORT(Deformation);
HWY_EXPORT(AddResidual);
HWY_EXPORT(AddTangent);

void solid_deformation(const SolidBlock& block, const SolidPoint& point, const double* corners,
                       PointDeformation& deformation) {
  HWY_DYNAMIC_DISPATCH(Deformation)(block, point, corners, deformation);
}

void solid_add_residual(const SolidBlock& block, const SolidPoint& point, const double (*stress)[kPointLanes],
                        double* residual) {
  HWY_DYNAMIC_DISPATCH(AddResidual)(block, point, stress, residual);
}

void solid_add_tangent(const SolidBlock& block, const SolidPoint& point, const double (*tangent)[kPointLanes],
                       double* blocks) {
  HWY_DYNAMIC_DISPATCH(AddTangent)(block, point, tangent, blocks);
}

}  // namespace tissued::core
#endif
