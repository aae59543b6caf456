// Pads, markers, targets and pushes at random for a body at random.
#pragma once

#include "core/scene.hpp"
#include "tests/study/pushes.hpp"

namespace tissued::study {

// One to three, on the upper part of the body; none where there is no room.
void add_pads(core::Scene& scene, Random& random);

// 8 to 24 markers and 1 to 4 targets. Markers are where truth has them, and said to be `offset` mm per axis from there.
void add_points(double offset, Random& random, core::Scene& scene, core::Scene& truth);

// Each pad alone, and sometimes two together; at most three ways, because each is solved for.
std::vector<Push> random_pushes(const core::Scene& scene, Random& random);

}  // namespace tissued::study
