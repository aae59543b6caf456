// Where a scene's markers, targets and surfaces lie on its mesh, and whether the scene can be simulated at all.
#pragma once

#include <string>
#include <vector>

#include "core/scene.hpp"

namespace tissued::core {

// Throws ModelError: numbers out of range, no tetrahedra, an inverted one.
void check_scene(const Scene& scene);

// Throws ModelError where the mesh has no such group; `what` needs it, in words.
const SurfaceGroup& surface_of(const TetMesh& mesh, const std::string& name, const std::string& what);

// The closest points of the skin and the pads; a marker that stands off by more than it may be placed wrongly is on a
// stalk that turns with the tissue. Throws ModelError where one is too far off.
std::vector<MaterialPoint> points_of_markers(const Scene& scene);

// Throws ModelError where a target lies outside the body.
std::vector<MaterialPoint> points_of_targets(const Scene& scene);

}  // namespace tissued::core
