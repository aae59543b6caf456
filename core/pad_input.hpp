// What one pad does in one frame.
#pragma once

#include <optional>

#include "core/types.hpp"

namespace tissued::core {

struct PadInput {
  enum class Kind : std::uint8_t { absent, pose, force };  // absent: off the skin
  Kind kind = Kind::absent;
  Vec3 center = Vec3::Zero();          // mm, tissue; where the pad's center is now (kind pose)
  Mat3 rotation = Mat3::Identity();    // tissue, relative to the rest pose (kind pose)
  Vec3 force = Vec3::Zero();           // N, of the pad on the tissue (kind force)
  std::optional<Vec3> measured_force;  // N, of the pad on the tissue, where a sensor says so beside the pose
};

}  // namespace tissued::core
