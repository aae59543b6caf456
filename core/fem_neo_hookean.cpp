#include "core/fem_neo_hookean.hpp"

#include <cmath>
#include <limits>

namespace tissued::core {

namespace {

using Lanes = double[kPointLanes];

// What both moduli multiply. H = F^-T.
struct alignas(64) Invariants {
  Lanes j, shape, i1, h[9];  // shape = J^(-2/3); zero where J <= 0
};

void invariants_of(const PointDeformation& deformation, Invariants& out) {
  inverse_transpose(deformation, out.j, out.h);
  for (int l = 0; l < kPointLanes; ++l) out.i1[l] = 0.0;
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < kPointLanes; ++l) out.i1[l] += deformation.f[k][l] * deformation.f[k][l];
  for (int l = 0; l < kPointLanes; ++l) {
    const double root = std::cbrt(out.j[l]);
    out.shape[l] = out.j[l] > 0 ? 1.0 / (root * root) : 0.0;
  }
}

// P = mu J^(-2/3) (F - I1/3 H) + kappa (J - 1) J H.
void stress_of(double mu, double kappa, const Lanes* f, const Invariants& v, Lanes* stress) {
  for (int k = 0; k < 9; ++k) {
    for (int l = 0; l < kPointLanes; ++l) {
      stress[k][l] +=
          mu * v.shape[l] * (f[k][l] - v.i1[l] / 3.0 * v.h[k][l]) + kappa * (v.j[l] - 1.0) * v.j[l] * v.h[k][l];
    }
  }
}

// dP = mu J^(-2/3) [dF - 2/3 (H:dF) F - 2/3 (F:dF) H + 2/9 I1 (H:dF) H + I1/3 H dF^T H]
//      + kappa [J (2J - 1) (H:dF) H - J (J - 1) H dF^T H]
void add_tangent(double mu, double kappa, const Lanes* f, const Invariants& v, Lanes* tangent) {
  alignas(64) Lanes alpha, outer, transposed;
  for (int l = 0; l < kPointLanes; ++l) {
    const double j = v.j[l];
    alpha[l] = mu * v.shape[l];
    outer[l] = 2.0 / 9.0 * alpha[l] * v.i1[l] + kappa * j * (2.0 * j - 1.0);
    transposed[l] = alpha[l] * v.i1[l] / 3.0 - kappa * j * (j - 1.0);
  }
  for (int r = 0; r < 9; ++r) {
    for (int c = 0; c <= r; ++c) {
      const int across = 3 * (r / 3) + c % 3, down = 3 * (c / 3) + r % 3;
      double* entry = tangent[pair_index(r, c)];
      for (int l = 0; l < kPointLanes; ++l) {
        entry[l] += outer[l] * v.h[r][l] * v.h[c][l] + transposed[l] * v.h[across][l] * v.h[down][l] -
                    2.0 / 3.0 * alpha[l] * (f[r][l] * v.h[c][l] + v.h[r][l] * f[c][l]) + (r == c ? alpha[l] : 0.0);
      }
    }
  }
}

}  // namespace

void FemNeoHookean::add(const PointBatch&, const PointDeformation& deformation, bool tangent,
                        PointResponse& response) const {
  const double mu = material_.shear_modulus(), kappa = material_.bulk_modulus();
  Invariants v;
  invariants_of(deformation, v);
  for (int l = 0; l < kPointLanes; ++l) {
    const double change = v.j[l] - 1.0;
    response.energy[l] += v.j[l] > 0 ? 0.5 * mu * (v.i1[l] * v.shape[l] - 3.0) + 0.5 * kappa * change * change
                                     : std::numeric_limits<double>::infinity();
  }
  stress_of(mu, kappa, deformation.f, v, response.stress);
  if (tangent) add_tangent(mu, kappa, deformation.f, v, response.tangent);
}

std::span<const FemParameter> FemNeoHookean::parameters() const {
  static const std::array<FemParameter, 2> kParameters{
      {{"youngs_modulus", "kPa", 1e-3, 1e6}, {"poissons_ratio", "1", 0.0, 0.4999}}};
  return kParameters;
}

double FemNeoHookean::parameter(int index) const {
  return index == 0 ? material_.youngs_modulus : material_.poissons_ratio;
}

void FemNeoHookean::set_parameter(int index, double value) {
  (index == 0 ? material_.youngs_modulus : material_.poissons_ratio) = value;
}

void FemNeoHookean::differentiate(int index, const PointBatch&, const PointDeformation& deformation,
                                  double (*stress)[kPointLanes]) const {
  const double e = material_.youngs_modulus, nu = material_.poissons_ratio;
  const double mu = material_.shear_modulus(), kappa = material_.bulk_modulus();
  Invariants v;
  invariants_of(deformation, v);
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < kPointLanes; ++l) stress[k][l] = 0.0;
  // Linear in both moduli: the derivative is the stress of the moduli's derivatives.
  if (index == 0)
    stress_of(mu / e, kappa / e, deformation.f, v, stress);
  else
    stress_of(-mu / (1.0 + nu), 2.0 * kappa / (1.0 - 2.0 * nu), deformation.f, v, stress);
}

}  // namespace tissued::core
