// From a body's answers at the keys of a path to what a tracker would have recorded at its frames: interpolation, and
// the faults that a measurement may have.
#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/load_path.hpp"
#include "core/rest_calibration.hpp"

namespace tissued::core {

// A marker that moved on the skin: from `time` of a trial on it is `shift` from where it was.
struct SlippedMarker {
  int marker = 0;
  int trial = 0;
  double time = 0.0;          // s
  Vec3 shift = Vec3::Zero();  // mm
};

struct MeasurementFaults {
  double latency = 0.0;          // s that markers and targets arrive later than pads
  Vec3 rotation = Vec3::Zero();  // rad, of the tracker's frame about the tissue's origin
  Vec3 shift = Vec3::Zero();     // mm
  std::vector<SlippedMarker> slips;
  std::vector<double> releases = {};  // (trials) s that a body was let go later than stated; empty: as stated
};

// Where a faulty registration sees what is at a place in tissue coordinates.
RigidTransform misplaced(const MeasurementFaults& faults);

// Numbers of `faults` by index: latency, rotation x y z, shift x y z, then x y z of every slip; -1, -2, ...: releases.
double& fault_number(MeasurementFaults& faults, int index);

// What these numbers are called: latency.seconds, registration.rotation.x, ..., marker-slip.M07.z.
std::vector<std::string> fault_names(const std::vector<SlippedMarker>& slips, const Scene& scene);

// (frames x channels), as RecordedTrial::seen but without gaps. answers: (keys x channels).
RowMatrix recorded(const RecordedTrial& trial, int trial_index, const LoadPath& path, const Scene& scene,
                   const RowMatrix& answers, const MeasurementFaults& faults);

}  // namespace tissued::core
