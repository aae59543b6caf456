#include "core/effects/isochoric_invariant.hpp"

#include <cmath>

namespace tissued::core {

void isochoric_invariant(const PointDeformation& deformation, const Mat3& m, IsochoricInvariant& out) {
  const auto& f = deformation.f;
  inverse_transpose(deformation, out.j, out.inverse);
  for (int l = 0; l < kPointLanes; ++l) {
    const double root = std::cbrt(out.j[l]);
    out.scale[l] = out.j[l] > 0 ? 1.0 / (root * root) : 0.0;
    out.value[l] = 0.0;
  }
  for (int i = 0; i < 3; ++i) {
    for (int c = 0; c < 3; ++c) {
      const int k = 3 * i + c;
      for (int l = 0; l < kPointLanes; ++l) {
        out.stretched[k][l] = f[3 * i][l] * m(0, c) + f[3 * i + 1][l] * m(1, c) + f[3 * i + 2][l] * m(2, c);
        out.value[l] += out.scale[l] * f[k][l] * out.stretched[k][l];
      }
    }
  }
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < kPointLanes; ++l)
      out.slope[k][l] = 2.0 * out.scale[l] * out.stretched[k][l] - 2.0 / 3.0 * out.value[l] * out.inverse[k][l];
}

// d2I/dF2 : dF = J^(-2/3) [2 dF M - 4/3 (H:dF) F M - 4/3 (FM:dF) H] + 4/9 I (H:dF) H + 2/3 I H dF^T H.
void add_isochoric_tangent(const IsochoricInvariant& v, const Mat3& m, const double* first, const double* second,
                           PointResponse& response) {
  alignas(64) double plain[kPointLanes], mixed[kPointLanes], outer[kPointLanes], turned[kPointLanes];
  for (int l = 0; l < kPointLanes; ++l) {
    plain[l] = 2.0 * first[l] * v.scale[l];
    mixed[l] = -4.0 / 3.0 * first[l] * v.scale[l];
    outer[l] = 4.0 / 9.0 * first[l] * v.value[l];
    turned[l] = 2.0 / 3.0 * first[l] * v.value[l];
  }
  for (int r = 0; r < 9; ++r) {
    for (int c = 0; c <= r; ++c) {
      const int across = 3 * (r / 3) + c % 3, down = 3 * (c / 3) + r % 3;
      const double weight = r / 3 == c / 3 ? m(r % 3, c % 3) : 0.0;
      double* entry = response.tangent[pair_index(r, c)];
      for (int l = 0; l < kPointLanes; ++l) {
        entry[l] += plain[l] * weight +
                    mixed[l] * (v.stretched[r][l] * v.inverse[c][l] + v.inverse[r][l] * v.stretched[c][l]) +
                    outer[l] * v.inverse[r][l] * v.inverse[c][l] +
                    turned[l] * v.inverse[across][l] * v.inverse[down][l] + second[l] * v.slope[r][l] * v.slope[c][l];
      }
    }
  }
}

}  // namespace tissued::core
