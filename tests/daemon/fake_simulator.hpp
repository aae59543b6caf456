#pragma once

#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "config/daemon_config.hpp"
#include "core/simulator.hpp"

// A block of one tetrahedron, markers M1 to M4 at corners, targets T1 (inside) and T2, pad A1 on the skin.
inline tissued::core::Scene small_scene() {
  using namespace tissued::core;
  Scene scene;
  scene.name = "small";
  scene.mesh.rest.resize(4, 3);
  scene.mesh.rest << 0, 0, 0, 40, 0, 0, 0, 40, 0, 0, 0, 40;
  scene.mesh.tets = {{0, 1, 2, 3}};
  scene.mesh.surfaces = {{"base", {{0, 2, 1}}}, {"skin", {{0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}, {"A1", {{1, 2, 3}}}};
  scene.pads = {{"A1", "A1", Vec3(13, 13, 13), Vec3(-1, 0, 0)}};
  scene.markers = {{"M1", Vec3(0, 0, 40)}, {"M2", Vec3(40, 0, 0)}, {"M3", Vec3(0, 40, 0)}, {"M4", Vec3(0, 0, 0)}};
  scene.targets = {{"T1", Vec3(5, 5, 5)}, {"T2", Vec3(8, 4, 2)}};
  scene.marker_noise = 0.1;
  scene.rate = 100.0;
  return scene;
}

// So many nodes in a row, and as many tetrahedra; no body, but none is asked for here.
inline tissued::core::Scene long_scene(int nodes) {
  tissued::core::Scene scene = small_scene();
  scene.mesh.rest.resize(nodes, 3);
  for (int i = 0; i < nodes; ++i) scene.mesh.rest.row(i) << 0.001 * i, 0.5, -1.25;
  scene.mesh.tets.clear();
  for (int i = 0; i < nodes; ++i) scene.mesh.tets.push_back({i, (i + 1) % nodes, (i + 2) % nodes, (i + 3) % nodes});
  return scene;
}

// No physics: everything moves by as much as marker M1 has moved in the last frame that showed it. What a test changes
// while the daemon runs is atomic.
class FakeSimulator : public tissued::core::Simulator {
 public:
  using Vec3 = tissued::core::Vec3;

  explicit FakeSimulator(tissued::core::Scene scene = small_scene()) : scene_(std::move(scene)) {
    rest_.setZero(scene_.mesh.node_count(), 4);
    rest_.leftCols<3>() = scene_.mesh.rest;
    positions_ = rest_;
  }

  const tissued::core::Scene& scene() const override { return scene_; }
  void reset() override {
    positions_ = rest_;
    shift_.setZero();
    ++resets;
  }

  tissued::core::StepReport step(const tissued::core::Observation& observation) noexcept override {
    while (stuck) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto began = std::chrono::steady_clock::now();
    const auto goes_on = [&] {
      return endless || std::chrono::steady_clock::now() - began < std::chrono::milliseconds(heavy_ms);
    };
    while (goes_on() && !observation.brake.pulled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (goes_on()) {
      endless = false;
      tissued::core::StepReport braked;
      braked.finite = false;
      braked.braked = true;
      return braked;
    }
    if (const int delay = delay_ms; delay > 0) std::this_thread::sleep_for(std::chrono::milliseconds(delay));
    ++steps;
    tissued::core::StepReport report;
    report.iterations = 10;
    report.markers_too_late = too_late;
    report.converged = converged;
    report.finite = finite;
    report.pad_ramp = pad_ramp;
    for (const auto seen : observation.marker_seen) report.markers_used += seen;
    report.markers_used -= rejected;
    if (!observation.marker_seen.empty() && observation.marker_seen[0]) {
      shift_ = observation.markers[0] - scene_.markers[0].rest;
    }
    positions_.leftCols<3>() = scene_.mesh.rest.rowwise() + shift_.transpose();
    if (keep_observations) {
      const std::lock_guard lock(mutex_);
      observations_.push_back(observation);
    }
    return report;
  }

  void set_time_step(double time_step) override {
    if (refuse_time_step) throw std::runtime_error("no such time step");
    time_step_ = time_step;
  }
  double time_step() const override { return time_step_; }
  const tissued::core::NodeField& positions() const override { return positions_; }
  tissued::core::TargetEstimate target(int index) const noexcept override {
    tissued::core::TargetEstimate estimate;
    estimate.position = scene_.targets[index].rest + shift_;
    if (poison_target) estimate.position.x() = std::numeric_limits<double>::quiet_NaN();
    estimate.covariance = Vec3(1, 4, 9).asDiagonal();
    return estimate;
  }
  Vec3 marker(int index) const noexcept override { return scene_.markers[index].rest + shift_; }
  Vec3 pad_force(int) const noexcept override { return {1, 2, 3}; }
  Vec3 probe_force(int) const noexcept override { return {4, 5, 6}; }
  std::uint64_t state_hash() const noexcept override { return 0; }

  std::vector<tissued::core::Observation> observations() const {
    const std::lock_guard lock(mutex_);
    return observations_;
  }

  std::atomic<bool> stuck{false};    // a step does not end before this does
  std::atomic<bool> endless{false};  // the next step does not end before it is braked
  std::atomic<int> heavy_ms{0};      // that a step takes, unless it is braked
  std::atomic<int> delay_ms{0};
  std::atomic<int> resets{0};
  std::atomic<int> steps{0};
  std::atomic<int> rejected{0};
  std::atomic<int> too_late{0};  // of the markers observed
  std::atomic<bool> converged{true};
  std::atomic<double> pad_ramp{0.0};
  std::atomic<bool> finite{true};
  std::atomic<bool> poison_target{false};
  std::atomic<bool> refuse_time_step{false};
  std::atomic<bool> keep_observations{true};

 private:
  tissued::core::Scene scene_;
  tissued::core::NodeField rest_, positions_;
  Vec3 shift_ = Vec3::Zero();  // mm
  std::atomic<double> time_step_{0.01};
  mutable std::mutex mutex_;
  std::vector<tissued::core::Observation> observations_;
};

// What a configuration file with nothing but defaults would say, ports aside: any free ones.
inline tissued::config::DaemonConfig small_config() {
  using namespace std::chrono_literals;
  tissued::config::DaemonConfig config;
  config.bundle.scene = small_scene();
  config.tracker.port = 0;
  config.tracker.frame_deadline = 4ms;
  config.clients.port = 0;
  config.clients.lease = 10s;
  config.registration.placement_sd = 0.0;  // offsets stay zero, so that what goes in comes out
  config.staleness = {100ms, 400ms};
  return config;
}
