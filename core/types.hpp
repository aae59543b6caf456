// The types and units of the core. Lengths are mm, times s, stresses kPa, densities g/cm3, forces N at the interface.
// Inside, mass is kg, so that kPa mm2 = kg mm/s2 = mN and no other factor appears; millinewton_per_newton converts.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <stdexcept>

namespace tissued::core {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

// (n x 4) mm, one row per node: x, y, z and a zero, so that a row is one 256-bit vector.
using NodeField = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

inline constexpr double kStandardGravity = 9806.65;        // mm/s2
inline constexpr double kKilogramPerDensityVolume = 1e-6;  // (g/cm3) mm3 -> kg
inline constexpr double kKilogramPerGram = 1e-3;
inline constexpr double kMillinewtonPerNewton = 1e3;

// What was asked cannot be built: what() is one line for the person who asked.
class ModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tissued::core
