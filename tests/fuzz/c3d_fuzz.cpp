// Any bytes as a C3D file: a sound trial that survives a round trip, rounded to float, or a TrialError.

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>

#include "protocol/c3d.hpp"
#include "tests/fuzz/trial_promises.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

bool fits_float(const std::array<double, 3>& position) {
  for (const double value : position) {
    if (std::abs(value) > std::numeric_limits<float>::max()) return false;
  }
  return true;
}

void check_round_trip(const Trial& trial) {
  std::string content;
  try {
    content = format_c3d(trial);
  } catch (const std::invalid_argument&) {
    return;  // labels longer, or more of them, than we write
  }
  const Trial again = parse_c3d(std::as_bytes(std::span(content)), "again.c3d");
  promise(again.labels == trial.labels && again.subjects == trial.subjects, "labels survive");
  promise(again.frame_count == trial.frame_count && again.first_frame == trial.first_frame, "frames survive");
  promise(again.rate_hz == trial.rate_hz, "the rate survives");
  for (std::size_t i = 0; i < trial.positions.size(); ++i) {
    if (!fits_float(trial.positions[i])) continue;
    promise(again.seen[i] == trial.seen[i], "gaps survive");
    for (int axis = 0; axis < 3 && trial.seen[i] != 0; ++axis) {
      promise(again.positions[i][axis] == static_cast<float>(trial.positions[i][axis]), "positions survive");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Trial trial;
  try {
    trial = parse_c3d(std::as_bytes(std::span(data, size)), "fuzz.c3d");
  } catch (const TrialError&) {
    return 0;
  }
  tissued::fuzz::check_trial(trial);
  check_round_trip(trial);
  return 0;
}
