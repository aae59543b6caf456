// The nodes and edges of a mesh that probes may touch.
#pragma once

#include <array>
#include <map>

#include "core/scene.hpp"

namespace tissued::core {

struct SkinOutline {
  // Each with the sum of the facets' normals around it (mm^2, outwards, at rest), as long as twice their area.
  std::map<int, Vec3> nodes;
  std::map<std::array<int, 2>, Vec3> edges;  // ends ascending
};

// Of the skin, and of the pads' places, where no pad may be. Throws ModelError where a group is missing.
SkinOutline skin_outline(const Scene& scene);

}  // namespace tissued::core
