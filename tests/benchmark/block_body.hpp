#pragma once

#include "core/scene.hpp"

namespace tissued::benchmark {

/// A block of 150 x 100 x 60 mm cut into about `tets` equal-sided cells of six tetrahedra each: base held, pad A1 of
/// 30 mm on the top, 19 markers on the top, one target.
core::Scene block_scene(int tets);

}  // namespace tissued::benchmark
