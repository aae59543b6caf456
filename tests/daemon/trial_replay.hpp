// A recorded trial as the observations that a simulator is given, calibrated on its first frame.
#pragma once

#include <optional>
#include <vector>

#include "core/rest_calibration.hpp"
#include "core/simulator.hpp"
#include "protocol/nexus_csv.hpp"

namespace tissued::daemon::testing {

inline core::Vec3 at(const protocol::Trial& trial, std::size_t frame, std::size_t label) {
  return core::Vec3(trial.position(frame, label).data());
}

class TrialReplay {
 public:
  TrialReplay(const core::Scene& scene, const protocol::Trial& trial) : scene_(scene), trial_(trial) {
    std::vector<core::Vec3> rest;
    for (const core::Marker& marker : scene.markers) rest.push_back(marker.rest);
    calibration_.emplace(rest, 0.5, scene.marker_noise, core::RigidTransform{}, false);
    observation_.resize_for(scene);
    raw_.resize(scene.markers.size());
    read(0);
    calibration_->add(raw_, observation_.marker_seen);
  }

  const core::Observation& frame(std::size_t f) {
    read(f);
    for (std::size_t m = 0; m < raw_.size(); ++m)
      observation_.markers[m] = calibration_->to_model(static_cast<int>(m), raw_[m]);
    return observation_;
  }

 private:
  void read(std::size_t f) {
    for (std::size_t p = 0; p < scene_.pads.size(); ++p) {
      const auto label = trial_.find_label(scene_.pads[p].name);
      observation_.pads[p].kind = label ? core::PadInput::Kind::pose : core::PadInput::Kind::absent;
      if (label) observation_.pads[p].center = at(trial_, f, *label);
    }
    for (std::size_t m = 0; m < raw_.size(); ++m) {
      const auto label = trial_.find_label(scene_.markers[m].name);
      observation_.marker_seen[m] = label && trial_.is_seen(f, *label);
      if (observation_.marker_seen[m]) raw_[m] = at(trial_, f, *label);
    }
  }

  const core::Scene& scene_;
  const protocol::Trial& trial_;
  std::optional<core::RestCalibration> calibration_;
  core::Observation observation_;
  std::vector<core::Vec3> raw_;
};

}  // namespace tissued::daemon::testing
