// I = J^(-2/3) F : F M for a symmetric M and its derivatives by F, eight points at a time: I1bar for the identity,
// I4bar for the square of a fibre direction. What energies of the change of shape alone are written in.
#pragma once

#include "core/fem_law.hpp"

namespace tissued::core {

struct alignas(64) IsochoricInvariant {
  double j[kPointLanes];
  double scale[kPointLanes];         // J^(-2/3); zero where J <= 0, and with it value and slope
  double value[kPointLanes];         // I
  double inverse[9][kPointLanes];    // H = F^-T
  double stretched[9][kPointLanes];  // F M
  double slope[9][kPointLanes];      // dI/dF = J^(-2/3) (2 F M - 2/3 (F : F M) H)
};

void isochoric_invariant(const PointDeformation& deformation, const Mat3& m, IsochoricInvariant& out);

// Adds first d2I/dF2 + second dI/dF dI/dF^T: the tangent of an energy W(I) with W' = first, W'' = second.
void add_isochoric_tangent(const IsochoricInvariant& invariant, const Mat3& m, const double* first,
                           const double* second, PointResponse& response);

}  // namespace tissued::core
