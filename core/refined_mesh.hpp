// A body in finer elements: what a coarse answer is judged by.
#pragma once

#include <array>
#include <vector>

#include "core/mesh.hpp"

namespace tissued::core {

struct RefinedMesh {
  TetMesh mesh;
  // (nodes of `mesh`) the coarse nodes whose middle it is, or was before it was moved onto the smooth surface; a coarse
  // node twice. Tetrahedra 8 t to 8 t + 7 are the pieces of t.
  std::vector<std::array<int, 2>> ends;
};

// Every tetrahedron in eight. New nodes of the boundary are put on the smooth surface that the coarse nodes lie on:
// along the normals of smooth facets, along the curves between surface groups; where facets meet at an angle the edge
// stays straight. Nodes of the coarse mesh stay, and come first.
RefinedMesh refined(const TetMesh& mesh);

}  // namespace tissued::core
