#pragma once

#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/fem_solver.hpp"
#include "core/static_solve.hpp"
#include "daemon/chosen_effects.hpp"

namespace tissued::daemon {

/// Where loads bring a body, whoever solved for it.
struct StaticAnswer {
  std::vector<std::array<double, 3>> rest;          ///< (n x 3) mm; the mesh's nodes, then those of quadratic edges
  std::vector<std::array<double, 3>> displacement;  ///< (n x 3) mm
  std::vector<core::Vec3> pad_forces;               ///< (pads) N, of the pad on the tissue
  std::vector<core::Vec3> markers, targets;         ///< mm, displacement
  bool converged = false;
  std::string summary;     ///< what it took, in words
  std::string trouble;     ///< empty, or why and where it stopped
  nlohmann::json figures;  ///< the same as numbers
};

StaticAnswer answer_of_admm(const core::Scene& scene, std::span<const core::PadInput> pads,
                            const core::StaticOptions& options,
                            const std::function<void(const core::StaticIteration&)>& watch);

struct FemRun {
  core::FemElement element = core::FemElement::p2;
  double tolerance = 1e-8;  ///< mm, of Newton's last correction
  double duration = 0.0;    ///< s that the pads travel, with inertia; 0: quasi-static
  double time_step = 0.01;  ///< s, of generalized-alpha
  double hold = 0.0;        ///< s that the pads stay before the answer is read; for effects with memory
  std::vector<core::EffectSetting> effects;
  int threads = 2;
};

/// With a duration: where the body is at its end, pads having travelled evenly. Displacements of markers and targets
/// are those of the element's own shape functions.
StaticAnswer answer_of_fem(const core::Scene& scene, std::span<const core::PadInput> pads, const FemRun& run);

struct PbdRun {
  core::PbdOptions options;
  double tolerance = 1e-4;  ///< mm that a particle moves in a time step at most, when the body has settled
  double load_step = 5.0;   ///< mm that pads move in a time step at most
  int max_iterations = 20000;
};

/// By time steps: the pads travel evenly, then stay until the body has settled. Pad forces are zero: pbd has none.
/// Throws core::ModelError.
StaticAnswer answer_of_pbd(const core::Scene& scene, std::span<const core::PadInput> pads, const PbdRun& run);

}  // namespace tissued::daemon
