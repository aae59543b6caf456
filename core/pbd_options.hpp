// Options of the simulator `pbd`. The defaults are those of Tagliabue et al. (Int J CARS 2019): what they held constant
// is their Table 1, the clusters are the breast phantom's row of Table 2. The row of the calibration phantom, a box of
// ballistic gel: cluster_spacing 9.6001, cluster_radius 9.1674, cluster_stiffness 0.45239.
#pragma once

namespace tissued::core {

// From particles to mesh nodes, markers and targets. `blend`: moving least squares over the particles around a point.
// `nearest`: the displacement of the particle that is nearest at rest, as in the paper.
enum class PbdReadout { blend, nearest };

struct PbdOptions {
  double particle_spacing = 5.0;       // mm, of the lattice
  double cluster_spacing = 11.1626;    // mm, at least, between the particles that clusters are seeded from
  double cluster_radius = 8.5424;      // mm; not below half of cluster_spacing
  double cluster_stiffness = 0.46489;  // alpha of equation (5), in [0, 1]
  double time_step = 0.02;             // s
  int substeps = 3;                    // of a time step
  int iterations = 9;                  // of a substep
  double damping = 12.0;               // 1/s; times a substep not above 1
  double collision_distance = 3.0;     // mm, that particles keep from a probe
  double shape_friction = 0.35;        // Coulomb's coefficient between particles and a probe, whatever Probe says
  double particle_friction = 0.25;     // Coulomb's coefficient between particles that collide
  bool self_collision = true;          // particles that were no neighbours at rest keep particle_spacing apart
  PbdReadout readout = PbdReadout::blend;

  double substep() const { return time_step / substeps; }  // s
};

}  // namespace tissued::core
