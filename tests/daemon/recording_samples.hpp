// A small bundle and a recording of it, made up for tests.
#pragma once

#include <cmath>
#include <limits>

#include "config/bundle.hpp"
#include "protocol/trial.hpp"

namespace tissued::daemon {

// One pad, three markers, two targets; no mesh.
inline config::Bundle sample_bundle() {
  config::Bundle bundle;
  bundle.scene.name = "sample";
  bundle.subject = "phantom";
  bundle.scene.pads.push_back({"A1", "A1", core::Vec3(50, 0, 0), core::Vec3(-1, 0, 0)});
  for (const char* name : {"M1", "M2", "M3"}) bundle.scene.markers.push_back({name, core::Vec3(0, 0, 60)});
  bundle.scene.targets.push_back({"T1", core::Vec3(1, 2, 30)});
  bundle.scene.targets.push_back({"T2", core::Vec3(-1, 2, 30)});
  bundle.marker_sets.push_back({"pair", {"M3", "M1"}});
  config::TrialInfo trial;
  trial.name = "push";
  bundle.trials.push_back(trial);
  return bundle;
}

// 200 Hz; frames 0 to 9 at rest, 10 to 29 moving in by 8 mm, 30 to 49 held, 50 to 59 moving out. M2 is not seen in
// frame 3, T2 never in the hold.
inline protocol::Trial sample_trial() {
  protocol::Trial trial;
  trial.file = "push.csv";
  trial.rate_hz = 200;
  trial.first_frame = 101;
  trial.frame_count = 60;
  trial.labels = {"M1", "M2", "M3", "T1", "T2", "A1"};
  trial.subjects.assign(6, "phantom");
  trial.devices = {"A1"};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t frame = 0; frame < trial.frame_count; ++frame) {
    const double i = static_cast<double>(frame);
    const double push = frame < 10 ? 0.0 : frame < 30 ? 0.4 * (i - 9.0) : frame < 50 ? 8.0 : 0.8 * (60.0 - i) - 0.8;
    for (std::size_t label = 0; label < 6; ++label) {
      const bool hidden = (label == 1 && frame == 3) || (label == 4 && frame >= 30 && frame < 50);
      trial.seen.push_back(hidden ? 0 : 1);
      if (hidden) {
        trial.positions.push_back({nan, nan, nan});
      } else if (label == 5) {
        trial.positions.push_back({50.0 - push, 0.0, 0.0});
      } else {
        trial.positions.push_back({static_cast<double>(label), 0.1 * push, 30.0});
      }
    }
    trial.forces.push_back({-push, 0.0, frame == 5 ? nan : 0.0});
  }
  return trial;
}

}  // namespace tissued::daemon
