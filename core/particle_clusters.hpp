// Clusters of particles for region-based shape matching: Tagliabue et al. 2019, equations (4) and (5), as NVIDIA FleX
// builds and solves them.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "core/particle_lattice.hpp"

namespace tissued::core {

// Immutable. The k-th member of cluster c is entry first[c] + k of `particle` and `arm`.
struct ParticleClusters {
  // Particles are taken in the lattice's order; one that is farther than `spacing` mm from all seeds so far becomes a
  // seed. A cluster holds the particles within `radius` mm of the mean of those within `spacing` of its seed. A
  // particle that no cluster reaches joins the cluster with the nearest mean, so that it stays attached to its
  // surroundings, which a cluster of its own would not do.
  ParticleClusters(const ParticleLattice& lattice, double spacing, double radius);

  int count() const { return static_cast<int>(first.size()) - 1; }
  int members(int cluster) const { return first[cluster + 1] - first[cluster]; }

  std::vector<int> first;            // (clusters + 1)
  std::vector<int> particle;         // (memberships)
  std::vector<Eigen::Vector4d> arm;  // (memberships) mm, at rest, from the cluster's mean; last its weight in that mean
  std::vector<double> share;         // (particles) one over the number of clusters that a particle is in
};

// What shape matching writes.
struct ClusterState {
  explicit ClusterState(const ParticleClusters& clusters);
  void reset();

  std::vector<Eigen::Quaterniond> rotation;  // (clusters) of the last match: where the next one starts
  NodeField goal;                            // (particles x 4) mm, scratch: sum of g_i over clusters
};

// One iteration: rotates and shifts the rest shape of every cluster onto its particles with least squares, (4),
// averages the goals of a particle over its clusters and moves it by alpha (g_i - p_i), (5). mobility: (particles) 0
// where a particle is held, else 1. x: (particles x 4) mm.
void match_shapes(const ParticleClusters& clusters, double alpha, std::span<const double> mobility, NodeField& x,
                  ClusterState& state);

}  // namespace tissued::core
