#include "core/probe_motion.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

namespace {

// mm, of the skin into the probe; negative where they do not touch.
double depth_at(const ProbeShape& shape, const RigidTransform& tissue_T_probe, std::span<const Vec3> at) {
  const RigidTransform probe_T_tissue = tissue_T_probe.inverse();
  double nearest = INFINITY;
  for (const Vec3& p : at) nearest = std::min(nearest, signed_distance(shape, probe_T_tissue(p)).distance);
  return -nearest;
}

// mm, how far the furthest corner of the probe is between two poses.
double travel_between(const ProbeShape& shape, const RigidTransform& from, const RigidTransform& to) {
  double furthest = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 sign(corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 4 ? 1.0 : -1.0);
    const Vec3 p = shape.center + sign.cwiseProduct(shape.half_extents);
    furthest = std::max(furthest, (to(p) - from(p)).norm());
  }
  return furthest;
}

// The probe's centre goes straight.
RigidTransform between(const ProbeShape& shape, const RigidTransform& from, const RigidTransform& to, double share) {
  RigidTransform pose = interpolate(from, to, share);
  const Vec3 start = from(shape.center), end = to(shape.center);
  pose.translation = start + share * (end - start) - pose.rotation * shape.center;
  return pose;
}

// `pose`, drawn back along the skin's normal until it is no deeper than `limit`.
RigidTransform drawn_back(const ProbeShape& shape, RigidTransform pose, std::span<const Vec3> at,
                          std::span<const Vec3> outwards, double limit) {
  constexpr int kMostSteps = 200;
  const RigidTransform probe_T_tissue = pose.inverse();
  Vec3 way = Vec3::Zero();
  for (std::size_t i = 0; i < at.size(); ++i)
    if (signed_distance(shape, probe_T_tissue(at[i])).distance < 0.0) way += outwards[i];
  way.normalize();
  for (int k = 0; k < kMostSteps && depth_at(shape, pose, at) > limit; ++k) pose.translation += limit * way;
  return pose;
}

}  // namespace

double ProbeMotion::follow(const ProbeShape& shape, const ProbeInput& input, std::span<const Vec3> at,
                           std::span<const Vec3> outwards, double limit) {
  if (!input.seen) {
    present_ = false;
    return 0.0;
  }
  const RigidTransform wanted = input.tissue_T_probe, before = pose_;
  double ahead = 0.0;
  if (depth_at(shape, wanted, at) <= limit) {
    pose_ = wanted;
  } else if (present_ && depth_at(shape, before, at) > -limit) {
    const double distance = travel_between(shape, before, wanted);
    pose_ = distance > limit ? between(shape, before, wanted, limit / distance) : wanted;
    ahead = std::max(0.0, distance - limit);
  } else {
    pose_ = drawn_back(shape, wanted, at, outwards, limit);
    ahead = travel_between(shape, pose_, wanted);
  }
  moved_ = present_ ? pose_ * before.inverse() : RigidTransform{};
  present_ = true;
  return ahead;
}

}  // namespace tissued::core
