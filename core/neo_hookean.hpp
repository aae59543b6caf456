// Equation (11) with J = det F, in plain doubles: what the vectorised local step is checked against, and the measure of
// whether an answer is an equilibrium.
#pragma once

#include <Eigen/LU>
#include <cmath>

#include "core/scene.hpp"

namespace tissued::core {

// kPa; infinite for det F <= 0.
inline double strain_energy_density(const Material& m, const Mat3& f) {
  const double j = f.determinant();
  if (!(j > 0)) return std::numeric_limits<double>::infinity();
  return 0.5 * m.shear_modulus() * (f.squaredNorm() / std::cbrt(j * j) - 3.0) +
         0.5 * m.bulk_modulus() * (j - 1) * (j - 1);
}

// First Piola-Kirchhoff stress, kPa: the derivative of (11) with respect to F. det F > 0.
inline Mat3 first_piola(double shear_modulus, double bulk_modulus, const Mat3& f) {
  const double j = f.determinant();
  const Mat3 inverse_transpose = f.inverse().transpose();
  const double alpha = shear_modulus / std::cbrt(j * j);
  return alpha * (f - f.squaredNorm() / 3.0 * inverse_transpose) + bulk_modulus * (j - 1) * j * inverse_transpose;
}

inline Mat3 first_piola(const Material& m, const Mat3& f) {
  return first_piola(m.shear_modulus(), m.bulk_modulus(), f);
}

}  // namespace tissued::core
