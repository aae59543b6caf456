#pragma once

#include "core/types.hpp"

namespace tissued::core {

// What the alarm says after a frame: whether the markers contradict the physics that is assumed, though the filter
// hides it at the markers themselves.
struct MismatchReport {
  bool watching = false;      // enough has been seen to judge
  bool raised = false;        // a diagnosis is due
  double level = 0.0;         // evidence in units of what raises the alarm; from 0
  double misfit = 0.0;        // mm, RMS per axis: what the assumed model misses at the markers, noise taken off
  Vec3 place = Vec3::Zero();  // mm, tissue: where a force would explain most of it; while there is evidence
  bool has_place = false;
};

}  // namespace tissued::core
