#pragma once

#include <cmath>

#include "protocol/trial.hpp"
#include "tests/fuzz/promise.hpp"

namespace tissued::fuzz {

// What Trial promises of every recording handed out.
inline void check_trial(const protocol::Trial& trial) {
  promise(std::isfinite(trial.rate_hz) && trial.rate_hz > 0.0, "the rate is a positive number");
  promise(trial.frame_count > 0, "there are frames");
  promise(trial.subjects.size() == trial.labels.size(), "every label has a subject or an empty one");
  promise(trial.positions.size() == trial.frame_count * trial.labels.size(), "a position per frame and label");
  promise(trial.seen.size() == trial.positions.size(), "a mask per position");
  promise(trial.forces.size() == trial.frame_count * trial.devices.size(), "a force per frame and device");
  for (std::size_t i = 0; i < trial.positions.size(); ++i) {
    for (const double value : trial.positions[i]) {
      promise(std::isfinite(value) == (trial.seen[i] != 0), "positions are finite where seen, else NaN");
    }
  }
  for (std::size_t i = 0; i < trial.labels.size(); ++i) {
    promise(!trial.labels[i].empty(), "labels are not empty");
    promise(trial.find_label(trial.labels[i]).has_value(), "labels are found");
  }
}

}  // namespace tissued::fuzz
