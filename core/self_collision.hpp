// Particles of different parts of one body that meet.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/particle_lattice.hpp"

namespace tissued::core {

// Pairs of particles on the body's surface that were more than two spacings apart at rest keep a spacing apart. What
// was nearer is one part, whose shape the clusters keep; what lies inside is shielded by the surface.
class SelfCollision {
 public:
  // friction: Coulomb's coefficient.
  SelfCollision(const ParticleLattice& lattice, double friction);

  // Collects the pairs that may collide in this substep. x: (particles x 4) mm.
  void find(const NodeField& x);
  // Pushes the two of a pair apart along the line between them, by equal parts where both are free, and takes back
  // their slide since the substep began up to friction times the push. start: (particles x 4) mm, when the substep
  // began. mobility: (particles) 0 where a particle is held, else 1.
  void resolve(std::span<const double> mobility, const NodeField& start, NodeField& x) const;

 private:
  using Cell = std::array<int, 3>;
  struct Pair {
    int one, other;
  };
  Cell cell_of(const Vec3& position) const;
  std::size_t bucket_of(const Cell& cell) const;
  void pair_with_cell(const NodeField& x, int one, const Cell& cell);

  double spacing_, friction_;
  std::vector<int> surface_;  // particles
  std::vector<Vec3> rest_;    // (surface) mm
  std::vector<Cell> cells_;   // (surface) of a grid of kReach spacings, now
  std::vector<int> head_;     // (buckets) first of `surface` in the bucket, or -1
  std::vector<int> next_;     // (surface) in the same bucket, or -1
  std::vector<Pair> pairs_;   // never more than its capacity: a crowd beyond it is not kept apart in this substep
};

}  // namespace tissued::core
