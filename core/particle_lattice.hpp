// A body filled with particles on a cubic lattice.
#pragma once

#include <array>
#include <vector>

#include "core/mesh.hpp"

namespace tissued::core {

class ParticleLattice {
 public:
  // Places a particle at the middle of every lattice cell whose middle lies in a tetrahedron. The lattice is parallel
  // to the axes and centred on the mesh's bounding box, so that a flat side of the box has particles within half a
  // spacing. spacing: mm. Throws ModelError where that makes no particles, or more cells than are sensible.
  ParticleLattice(const TetMesh& mesh, double spacing);

  int count() const { return static_cast<int>(rest_.size()); }
  double spacing() const { return spacing_; }                                                 // mm
  const Vec3& rest(int particle) const { return rest_[static_cast<std::size_t>(particle)]; }  // mm, tissue
  // One of the particle's six neighbouring cells is empty.
  bool on_surface(int particle) const;
  // Particles at most `radius` mm from `center`, ascending.
  std::vector<int> within(const Vec3& center, double radius) const;
  // The particle next to `position`; the lowest index of several.
  int nearest(const Vec3& position) const;

 private:
  using Cell = std::array<int, 3>;
  int index(const Cell& cell) const { return (cell[2] * cells_[1] + cell[1]) * cells_[0] + cell[0]; }
  Vec3 middle(const Cell& cell) const { return first_ + spacing_ * Vec3(cell[0], cell[1], cell[2]); }
  Cell cell_at(const Vec3& position) const;
  void fill(const TetMesh& mesh);

  double spacing_;
  Vec3 first_;                    // mm, tissue: middle of cell 0, 0, 0
  Cell cells_{};                  // along the axes
  std::vector<int> particle_of_;  // (cells) -1 where the cell is empty
  std::vector<Cell> cell_;        // (particles)
  std::vector<Vec3> rest_;        // (particles)
};

}  // namespace tissued::core
