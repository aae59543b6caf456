// Small bodies for the tests of core: boxes of cubes, each cut into six tetrahedra, with everything a scene names.
#pragma once

#include <random>

#include "core/effects/effect_setting.hpp"
#include "core/scene.hpp"

namespace tissued::core::testing {

struct BoxSize {
  int nx = 4, ny = 3, nz = 2;  // cubes
  double edge = 10.0;          // mm, of a cube
};

// Uniform in [-1, 1], reproducible on every platform (std::uniform_real_distribution is not).
double symmetric_random(std::mt19937& generator);
Vec3 random_vector(std::mt19937& generator);
Mat3 random_matrix(std::mt19937& generator);
Mat3 random_rotation(std::mt19937& generator);

// Inner nodes are moved by up to 15 % of an edge. Groups: base (z = 0), A1 and A2 (two patches of the top that touch,
// so that they share nodes), skin (the rest). Markers on top and sides, 0.3 mm off; three targets inside.
Scene box_scene(const BoxSize& size, int markers = 7);

// Effects of every sort at once: laws with a memory, terms, a field, pads that slide, a support that is loose in part.
std::vector<EffectSetting> many_effects(const Scene& scene);

// Of the pads' nodes, those that both hold.
std::vector<int> shared_nodes(const TetMesh& mesh, const std::string& one, const std::string& other);

}  // namespace tissued::core::testing
