#include "core/probe.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tissued::core {

SignedDistance signed_distance(const ProbeShape& shape, const Vec3& p) {
  const Vec3 local = p - shape.center;
  const Vec3 inner = shape.half_extents.array() - shape.rounding;
  const Vec3 beyond = local.cwiseAbs() - inner;
  const Vec3 outside = beyond.cwiseMax(0.0);
  const double far = outside.norm();
  SignedDistance result;
  const auto sign = [&](int axis) { return local[axis] < 0.0 ? -1.0 : 1.0; };
  if (far > 0.0) {
    result.distance = far - shape.rounding;
    for (int axis = 0; axis < 3; ++axis) result.normal[axis] = sign(axis) * outside[axis] / far;
    return result;
  }
  int nearest = 0;
  result.distance = beyond.maxCoeff(&nearest) - shape.rounding;
  result.normal = sign(nearest) * Vec3::Unit(nearest);
  return result;
}

bool is_sound(const ProbeInput& input) {
  constexpr double kFurthest = 1e6;  // mm
  constexpr double kSkew = 1e-3;
  if (!input.seen) return true;
  const RigidTransform& pose = input.tissue_T_probe;
  if (!pose.translation.allFinite() || !pose.rotation.allFinite()) return false;
  const double skew = (pose.rotation * pose.rotation.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff();
  return pose.translation.cwiseAbs().maxCoeff() <= kFurthest && skew <= kSkew && pose.rotation.determinant() > 0.0;
}

}  // namespace tissued::core
