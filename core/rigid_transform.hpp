// A rotation and a translation between two frames of space: `a_T_b` takes points of b to a.
#pragma once

#include "core/types.hpp"

namespace tissued::core {

struct RigidTransform {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();  // mm

  Vec3 operator()(const Vec3& p) const { return rotation * p + translation; }
  RigidTransform operator*(const RigidTransform& first) const {
    return {rotation * first.rotation, rotation * first.translation + translation};
  }
  RigidTransform inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

// Between two poses: the turn at constant speed, the frame's origin on a straight line. share: 0 for `from`, 1 for
// `to`.
RigidTransform interpolate(const RigidTransform& from, const RigidTransform& to, double share);

}  // namespace tissued::core
