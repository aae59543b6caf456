// Bodies of no particular kind, in tetrahedra: boxes, domes and loaves of random size, fineness and irregularity.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.hpp"
#include "tests/study/random.hpp"

namespace tissued::study {

struct Body {
  std::string shape;   // box, dome (half an ellipsoid, flat below) or loaf (half a cylinder of elliptic section)
  core::TetMesh mesh;  // groups base (z = 0) and skin (the rest)
};

// 40 to 120 mm along its longest side; some 350 to 700 tetrahedra, now and then up to 1500 (a truth takes eight times
// as many).
Body random_body(Random& random);

// Takes a round patch of the skin into a group of its own: facets within `radius` of `middle`. False, and nothing
// changed, where that would touch the base or another patch, or has less than four facets.
bool cut_patch(core::TetMesh& mesh, const std::string& name, const core::Vec3& middle, double radius);

}  // namespace tissued::study
