// The cases of ../shared/reference as scenes and pads, and how far an answer is from what FEniCSx found.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/simulator.hpp"

namespace tissued::daemon::testing {

// index.json, one entry a case; null, with a warning, where the reference answers are not there.
nlohmann::json reference_index();

// Markers and targets where the reference read them, which is inside the mesh.
core::Scene reference_scene(const nlohmann::json& asked);
std::vector<core::PadInput> reference_pads(const core::Scene& scene, const nlohmann::json& asked);

// mm; moved: (corner nodes x 3) mm, against NAME.csv.
double furthest_from_reference(const core::Scene& scene, const Eigen::MatrixX3d& moved, const std::string& name);
// N; answer: the case's P1 or P2.
double worst_force(const core::Scene& scene, const std::vector<core::Vec3>& pad_forces, const nlohmann::json& answer);

}  // namespace tissued::daemon::testing
