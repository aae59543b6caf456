// An ultrasound probe: a rigid body that may press on the skin anywhere, and slide on it.
#pragma once

#include <string>

#include "core/rigid_transform.hpp"
#include "core/types.hpp"

namespace tissued::core {

// A box with rounded edges in the probe's own frame, that of its tracked object.
struct ProbeShape {
  Vec3 center = Vec3::Zero();                 // mm, probe
  Vec3 half_extents = Vec3(20.0, 8.0, 30.0);  // mm, along the probe's axes, rounding included
  double rounding = 3.0;                      // mm, radius of edges and corners; not above the smallest half extent
};

// How far a point is outside of a probe's surface, and which way is out.
struct SignedDistance {
  double distance = 0.0;        // mm, negative inside
  Vec3 normal = Vec3::UnitZ();  // unit, outwards: the distance's gradient
};

// p: mm, probe. Exact outside; inside of the core box the distance to its nearest face.
SignedDistance signed_distance(const ProbeShape& shape, const Vec3& p);

struct Probe {
  std::string name;  // of the tracked object
  ProbeShape shape;
  double friction = 0.0;  // Coulomb's coefficient between probe and skin; gel leaves next to none
};

// What one probe does in one frame.
struct ProbeInput {
  bool seen = false;  // by the tracker; an unseen probe does not touch
  RigidTransform tissue_T_probe;
};

// False where a seen pose is no place for a probe: not finite, further off than any tracker sees, or not a rotation.
bool is_sound(const ProbeInput& input);

}  // namespace tissued::core
