#pragma once

#include <memory>
#include <vector>

#include "core/fem_law.hpp"
#include "core/scene.hpp"

namespace tissued::core {

// The stress of a damping matrix beta K(rest): beta (C : dF) / dt of what F changed since the last accepted state, its
// share that changes the shape and its share that changes the volume. beta: s.
void add_damping_laws(const Material& material, double beta, std::vector<std::unique_ptr<FemLaw>>& laws);

}  // namespace tissued::core
