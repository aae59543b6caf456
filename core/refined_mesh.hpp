// A body in finer elements: what a coarse answer is judged by.
#pragma once

#include "core/mesh.hpp"

namespace tissued::core {

// Every tetrahedron in eight. New nodes of the boundary are put on the smooth surface that the coarse nodes lie on:
// along the normals of smooth facets, along the curves between surface groups; where facets meet at an angle the edge
// stays straight. Nodes of the coarse mesh stay, and come first; tetrahedra 8 t to 8 t + 7 are the pieces of t.
TetMesh refined(const TetMesh& mesh);

}  // namespace tissued::core
