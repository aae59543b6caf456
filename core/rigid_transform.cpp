#include "core/rigid_transform.hpp"

#include <Eigen/Geometry>

namespace tissued::core {

RigidTransform interpolate(const RigidTransform& from, const RigidTransform& to, double share) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond(from.rotation).slerp(share, Eigen::Quaterniond(to.rotation));
  return {turn.normalized().toRotationMatrix(), (1.0 - share) * from.translation + share * to.translation};
}

}  // namespace tissued::core
