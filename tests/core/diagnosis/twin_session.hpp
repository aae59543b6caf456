// Recordings of a body of our own, with any physics that the scene does not assume: what a diagnosis is tried on.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/diagnosis/recorder.hpp"
#include "core/diagnosis/session.hpp"
#include "core/effects/effect.hpp"

namespace tissued::core::testing {

struct TwinTruth {
  std::vector<std::pair<std::string, double>> numbers;  // of FemModel, e.g. youngs_modulus, viscoelasticity.g1
  std::vector<std::string> effects;                     // kinds
  double latency = 0.0;                                 // s
  std::vector<const Effect*> others = {};               // that the library does not know
  double marker_noise = 0.1;                            // mm per axis
  Vec3 rotation = Vec3::Zero(), shift = Vec3::Zero();   // rad and mm, of the tracker's frame
  std::vector<SlippedMarker> slips = {};                // by the index of the trial; the held-out ones come last
};

// Three trials (each pad alone, then the first quickly) and one held out (both pads) of a small box: push, hold,
// release, rest at 50 Hz. Truth by quadratic elements on the scene's mesh, with the stated noise; seed of the noise.
RecordedSession twin_session(const TwinTruth& truth, unsigned seed);

// Pads of a trial that goes to `depth` mm with the pads of these indices at `speed` mm/s, and comes back after a hold.
RecordedTrial push_trial(const Scene& scene, const std::string& name, const std::vector<int>& pads, double depth,
                         double speed);

}  // namespace tissued::core::testing
