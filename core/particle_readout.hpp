// Where points of a body are, told from its particles.
#pragma once

#include <span>
#include <vector>

#include "core/mesh.hpp"
#include "core/particle_lattice.hpp"
#include "core/pbd_options.hpp"

namespace tissued::core {

// Displacement of a point = sum of weights times displacements of particles. Immutable.
class ParticleReadout {
 public:
  // A point of the body at rest, mm; where it stands off the body, `foot` is the body's point below it.
  struct Point {
    Vec3 position;
    Vec3 foot;
  };
  static Point point_at(const TetMesh& mesh, const MaterialPoint& point);

  // `nearest`: the particle nearest to the foot. `blend`: moving least squares with a linear basis and the weights
  // (1 - (r/s)^2)^2 around the foot, which returns every affine motion exactly; s is two spacings, and more where too
  // few particles are so near.
  ParticleReadout(const ParticleLattice& lattice, PbdReadout kind, std::span<const Point> points);

  int count() const { return static_cast<int>(first_.size()) - 1; }
  // rest, x: (particles x 4) mm. Returns mm.
  Vec3 displacement(int point, const NodeField& rest, const NodeField& x) const;

 private:
  void add_nearest(const ParticleLattice& lattice, const Point& point);
  void add_blend(const ParticleLattice& lattice, const Point& point);

  // Of point k: entries first_[k] to first_[k + 1].
  std::vector<int> first_{0};
  std::vector<int> particle_;
  std::vector<double> weight_;
};

}  // namespace tissued::core
