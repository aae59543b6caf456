// Linear tetrahedra, and points that ride on them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace tissued::core {

using Tet = std::array<int, 4>;
using Triangle = std::array<int, 3>;

struct SurfaceGroup {
  std::string name;
  std::vector<Triangle> triangles;
};

struct TetMesh {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> rest;  // (n x 3) mm, tissue frame
  std::vector<Tet> tets;                                           // positive volume
  std::vector<SurfaceGroup> surfaces;                              // named facets: base, skin, pads

  int node_count() const { return static_cast<int>(rest.rows()); }
  int tet_count() const { return static_cast<int>(tets.size()); }
  Vec3 node(int i) const { return rest.row(i).transpose(); }
  // nullptr where there is none of that name.
  const SurfaceGroup* find_surface(const std::string& name) const;
};

// The nodes of a group of facets, ascending, each once.
std::vector<int> nodes_of(const SurfaceGroup& group);

// Six times the signed volume is det(x1 - x0, x2 - x0, x3 - x0). mm3.
double signed_volume(const TetMesh& mesh, const Tet& tet);

// A material point: position = sum_a weights[a] x[nodes[a]] (+ offset where it does not lie in the mesh).
// Entries beyond `count` are zero weights on node 0, so that loops of fixed length are right, too.
struct MaterialPoint {
  std::array<int, 4> nodes{};
  std::array<double, 4> weights{};
  int count = 0;
  double distance = 0.0;  // mm, from the point asked for to the material point
  // Of what stands off the body and turns with it: how far it is from the body's point, in the coordinates that
  // `weights` are; weights include it. Sums to 0.
  std::array<double, 4> stalk{};
};

Vec3 rest_position(const TetMesh& mesh, const MaterialPoint& point);

// Barycentric coordinates in a tetrahedron, wherever `position` lies.
std::array<double, 4> barycentric_in(const TetMesh& mesh, const Tet& tet, const Vec3& position);

// The tetrahedron that holds `position`, or the one whose nearest point is closest (distance > 0 then).
MaterialPoint locate_in_volume(const TetMesh& mesh, const Vec3& position);

// The closest point on the given facets.
MaterialPoint locate_on_surface(const TetMesh& mesh, const std::vector<Triangle>& facets, const Vec3& position);

// The boundary of the mesh: facets that belong to one tetrahedron only, oriented outwards.
std::vector<Triangle> boundary_of(const TetMesh& mesh);

}  // namespace tissued::core
