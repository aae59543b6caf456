#include "core/polar_rotation.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <limits>

namespace tissued::core {

namespace {

constexpr int kMostIterations = 12;
// rad; convergence is quadratic, so that after such a step only rounding is left.
constexpr double kLastStep = 1e-6;
constexpr double kUndetermined = 1e-9;  // of the size of `a`

Mat3 rotation_by_svd(const Mat3& a) {
  const Eigen::JacobiSVD<Mat3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handed = svd.matrixU().determinant() * svd.matrixV().determinant();
  return svd.matrixU() * Vec3(1.0, 1.0, handed < 0.0 ? -1.0 : 1.0).asDiagonal() * svd.matrixV().transpose();
}

bool is_positive(const Mat3& g) {
  return g(0, 0) > 0.0 && g(0, 0) * g(1, 1) - g(0, 1) * g(0, 1) > 0.0 && g.determinant() > 0.0;
}

}  // namespace

void polar_rotation(const Mat3& a, Eigen::Quaterniond& rotation) {
  // Holds on to the rotation that is there, so weakly that it counts only where `a` says nothing.
  const double hold = kUndetermined * a.norm();
  if (hold == 0.0) return;
  const Mat3 target = a + hold * rotation.toRotationMatrix();
  for (int k = 0; k < kMostIterations; ++k) {
    // With R exp([w]) for R: tr = const + w . v - w . G w / 2 up to second order.
    const Mat3 m = rotation.toRotationMatrix().transpose() * target;
    const Vec3 v(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
    const Mat3 g = m.trace() * Mat3::Identity() - 0.5 * (m + m.transpose());
    if (!is_positive(g)) break;
    const Vec3 w = g.inverse() * v;
    rotation = (rotation * Eigen::Quaterniond(1.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z())).normalized();
    if (w.squaredNorm() < kLastStep * kLastStep) return;
  }
  if (target.allFinite()) {
    rotation = Eigen::Quaterniond(rotation_by_svd(target)).normalized();
  } else {
    rotation.coeffs().setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace tissued::core
