// Particles against probes: unilateral contact with Coulomb friction, by positions.
#pragma once

#include <span>
#include <vector>

#include "core/probe.hpp"
#include "core/types.hpp"

namespace tissued::core {

// A probe during a substep.
struct ProbeMotion {
  RigidTransform begin, end;  // tissue_T_probe
};

class ProbeContact {
 public:
  // distance: mm, that particles keep from the probe. reach: mm, how far beyond it `find` looks.
  ProbeContact(const ProbeShape& shape, double distance, double reach, double friction, std::size_t particles);

  // Collects the particles that the probe may touch in this substep. mobility: (particles) 0 where a particle is held,
  // which no probe moves. x: (particles x 4) mm.
  void find(const ProbeMotion& motion, std::span<const double> mobility, const NodeField& x);
  // Pushes what was found out of the probe along its normal, and takes back as much of the slide against the probe's
  // own motion since the substep began as Coulomb's cone allows: friction times the push (Macklin et al., Unified
  // Particle Physics for Real-Time Applications, 2014, section 6.1). start: (particles x 4) mm, when the substep began.
  void resolve(const ProbeMotion& motion, const NodeField& start, NodeField& x) const;

 private:
  ProbeShape shape_;
  double distance_, reach_, friction_;
  std::vector<int> found_;
};

// Between two poses: the turn at constant speed, the frame's origin on a straight line. share: 0 for `from`, 1 for
// `to`.
RigidTransform interpolate(const RigidTransform& from, const RigidTransform& to, double share);

}  // namespace tissued::core
