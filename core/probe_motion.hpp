// How a probe of the simulation follows the tracked one: at once, unless that would leave it deep in the tissue.
#pragma once

#include <span>

#include "core/probe.hpp"

namespace tissued::core {

class ProbeMotion {
 public:
  // Back off the skin.
  void forget() { present_ = false; }

  // One step. at: (places) mm, tissue, where the skin is; outwards: (places) its normals at rest. limit: mm, deeper
  // than which no place is to come into the probe at once: a jump of the pose is ramped, and a probe that appears
  // inside of the body comes in from outside. Returns mm by which the tracked probe is ahead. input: sound.
  double follow(const ProbeShape& shape, const ProbeInput& input, std::span<const Vec3> at,
                std::span<const Vec3> outwards, double limit);

  bool present() const { return present_; }
  const RigidTransform& pose() const { return pose_; }  // tissue_T_probe
  // What the last step did to points that ride on the probe.
  const RigidTransform& moved() const { return moved_; }

 private:
  bool present_ = false;
  RigidTransform pose_, moved_;
};

}  // namespace tissued::core
