// Particles against probes: unilateral contact with Coulomb friction, by positions.
#pragma once

#include <span>
#include <vector>

#include "core/probe.hpp"
#include "core/types.hpp"

namespace tissued::core {

// A probe during a substep.
struct PoseChange {
  RigidTransform begin, end;  // tissue_T_probe
};

class ParticleContact {
 public:
  // distance: mm, that particles keep from the probe. reach: mm, how far beyond it `find` looks.
  ParticleContact(const ProbeShape& shape, double distance, double reach, double friction, std::size_t particles);

  // Collects the particles that the probe may touch in this substep. mobility: (particles) 0 where a particle is held,
  // which no probe moves. x: (particles x 4) mm.
  void find(const PoseChange& motion, std::span<const double> mobility, const NodeField& x);
  // Pushes what was found out of the probe along its normal, and takes back as much of the slide against the probe's
  // own motion since the substep began as Coulomb's cone allows: friction times the push (Macklin et al., Unified
  // Particle Physics for Real-Time Applications, 2014, section 6.1). start: (particles x 4) mm, when the substep began.
  // Returns how many were pushed.
  int resolve(const PoseChange& motion, const NodeField& start, NodeField& x) const;
  // mm: how deep a particle that was found is in the probe, at most. 0 where none is.
  double penetration(const PoseChange& motion, const NodeField& x) const;

 private:
  ProbeShape shape_;
  double distance_, reach_, friction_;
  std::vector<int> found_;
};

}  // namespace tissued::core
