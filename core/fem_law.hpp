// What a material answers at a quadrature point, eight points at a time. The laws of a body are summed point by point.
#pragma once

#include "core/fem_term.hpp"

namespace tissued::core {

inline constexpr int kPointLanes = 8;

// Deformation gradients F, row-major 3 x 3.
struct alignas(64) PointDeformation {
  double f[9][kPointLanes];
};

// J = det F and H = F^-T, row-major; H is zero where J <= 0.
inline void inverse_transpose(const PointDeformation& deformation, double (&j)[kPointLanes],
                              double (&h)[9][kPointLanes]) {
  const auto& f = deformation.f;
  for (int l = 0; l < kPointLanes; ++l) {
    const double cofactor[9] = {
        f[4][l] * f[8][l] - f[5][l] * f[7][l], f[5][l] * f[6][l] - f[3][l] * f[8][l],
        f[3][l] * f[7][l] - f[4][l] * f[6][l], f[2][l] * f[7][l] - f[1][l] * f[8][l],
        f[0][l] * f[8][l] - f[2][l] * f[6][l], f[1][l] * f[6][l] - f[0][l] * f[7][l],
        f[1][l] * f[5][l] - f[2][l] * f[4][l], f[2][l] * f[3][l] - f[0][l] * f[5][l],
        f[0][l] * f[4][l] - f[1][l] * f[3][l],
    };
    j[l] = f[0][l] * cofactor[0] + f[1][l] * cofactor[1] + f[2][l] * cofactor[2];
    const double inverse = j[l] > 0 ? 1.0 / j[l] : 0.0;
    for (int k = 0; k < 9; ++k) h[k][l] = cofactor[k] * inverse;
  }
}

// Per rest volume. `tangent`: dP/dF, a symmetric 9 x 9, lower triangle in the order of pair_index.
struct alignas(64) PointResponse {
  double energy[kPointLanes];       // kPa
  double stress[9][kPointLanes];    // kPa, first Piola-Kirchhoff, row-major
  double tangent[45][kPointLanes];  // kPa
};

// Which points these are. Lanes past the last element repeat it.
struct PointBatch {
  int index = 0;                    // from 0, through all batches of the body
  double time_step = 0.0;           // s, as TermInput
  const double* history = nullptr;  // (history_per_point x kPointLanes) of this law and batch
};

class FemLaw : public FemAdjustable {
 public:
  virtual std::string_view name() const = 0;
  // True of a law about the change of volume: elements that average the volume elsewhere than the shape evaluate it
  // there.
  virtual bool on_volume() const { return false; }
  // Adds its energy and stress, and its tangent where `tangent`. A point with det F <= 0 whose energy is not defined
  // gets infinite energy and no stress. Called from several threads at once.
  virtual void add(const PointBatch& batch, const PointDeformation& deformation, bool tangent,
                   PointResponse& response) const = 0;

  // Overwrites `stress` (as in PointResponse) with its derivative by parameter `index`.
  virtual void differentiate(int, const PointBatch&, const PointDeformation&, double (*)[kPointLanes]) const {}

  // Doubles a point that the law keeps from one accepted state to the next; zero at rest.
  virtual int history_per_point() const { return 0; }
  // Writes the history that follows on batch.history, (history_per_point x kPointLanes).
  virtual void accept(const PointBatch&, const PointDeformation&, double*) const {}
};

// What all moduli of a body are multiplied with, from place to place: at each quadrature point, or the mean over the
// element where the rule has a negative weight (that of degree 3).
class FemField : public FemAdjustable {
 public:
  // Natural logarithm of the factor; rest: mm, tissue.
  virtual double log_factor(const Vec3& rest) const = 0;
};

}  // namespace tissued::core
