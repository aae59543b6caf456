// A body of particles: everything about `pbd` that does not change while it runs. Particles within half a spacing of
// the fixed surface are held; those within a spacing of a pad's facets, and not held, go with the pad's pose or share
// its force.
#pragma once

#include <vector>

#include "core/particle_clusters.hpp"
#include "core/particle_lattice.hpp"
#include "core/particle_readout.hpp"
#include "core/pbd_options.hpp"
#include "core/scene.hpp"

namespace tissued::core {

struct PbdModel {
  // Throws ModelError where the scene cannot be simulated, or no particle is at the fixed surface or at a pad.
  PbdModel(const Scene& scene, const PbdOptions& options);

  Scene scene;
  PbdOptions options;
  ParticleLattice lattice;
  ParticleClusters clusters;
  NodeField rest;                               // (particles x 4) mm, tissue
  std::vector<double> mobility;                 // (particles) 0 at the base, else 1
  std::vector<std::vector<int>> pad_particles;  // (pads) those that a pad takes along, without the base's
  double particle_mass;                         // kg; together they weigh what the body does
  Eigen::RowVector4d gravity;                   // mm/s2
  ParticleReadout nodes, markers, targets;      // of the mesh and the scene

 private:
  void hold_base();
  void glue_pads();
};

}  // namespace tissued::core
