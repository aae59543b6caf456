#include "core/rigid_simulator.hpp"

#include <cmath>

#include "core/rest_calibration.hpp"
#include "core/scene_places.hpp"
#include "core/state_hash.hpp"

namespace tissued::core {

RigidSimulator::RigidSimulator(const Scene& scene, const SimulatorOptions& options)
    : scene_(scene), options_(options.rigid), time_step_(options.solver.time_step) {
  check_scene(scene_);
  points_of_markers(scene_);
  points_of_targets(scene_);
  from_.reserve(scene_.markers.size());
  to_.reserve(scene_.markers.size());
  positions_.setZero(scene_.mesh.node_count(), 4);
  reset();
}

void RigidSimulator::reset() {
  motion_ = RigidTransform{};
  publish();
}

void RigidSimulator::publish() {
  for (int i = 0; i < scene_.mesh.node_count(); ++i)
    positions_.row(i).head<3>() = motion_(scene_.mesh.node(i)).transpose();
}

StepReport RigidSimulator::step(const Observation& observation) noexcept {
  StepReport report;
  report.converged = true;
  if (options_.follow == RigidOptions::Follow::markers) follow(observation, report);
  return report;
}

void RigidSimulator::follow(const Observation& observation, StepReport& report) {
  from_.clear();
  to_.clear();
  for (std::size_t i = 0; i < scene_.markers.size(); ++i) {
    if (!observation.marker_seen[i] || !std::isfinite(observation.markers[i].squaredNorm())) continue;
    from_.push_back(scene_.markers[i].rest);
    to_.push_back(observation.markers[i]);
  }
  const Registration fitted = register_rigid(from_, to_);
  if (!fitted.determined) return;
  motion_ = fitted.tissue_from_tracker;
  publish();
  report.markers_used = fitted.points;
  report.innovation_rms = fitted.residual_rms / std::sqrt(3.0);
}

TargetEstimate RigidSimulator::target(int index) const noexcept {
  return {motion_(scene_.targets[static_cast<std::size_t>(index)].rest), Mat3::Zero()};
}

Vec3 RigidSimulator::marker(int index) const noexcept {
  return motion_(scene_.markers[static_cast<std::size_t>(index)].rest);
}

std::uint64_t RigidSimulator::state_hash() const noexcept {
  StateHash hash;
  hash.mix(motion_.rotation.data(), motion_.rotation.size());
  hash.mix(motion_.translation.data(), motion_.translation.size());
  return hash.value();
}

}  // namespace tissued::core
