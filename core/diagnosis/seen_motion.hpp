// What the pads and markers of a recording show of how fast things go.
#pragma once

#include <vector>

#include "core/diagnosis/session.hpp"

namespace tissued::core {

inline constexpr double kStillSpeed = 0.2;  // mm/s; of a pad: slower is a hold

// mm, between two poses of the pad that differs most; a turn counts, and a pad that came or went is 1e9 away.
double largest_distance(const std::vector<PadInput>& a, const std::vector<PadInput>& b);

// mm, of any marker in any frame; a single frame is no measure.
double largest_displacement(const RecordedTrial& trial, const Scene& scene);

// s, from when on all markers stay near to where they end; the end where they do not, or where pads still move. peak:
// mm, of the markers.
double calm_time(const RecordedTrial& trial, const Scene& scene, double peak);

// s, of the fastest swing that is seen about where a body comes to rest; what is usual of soft tissue where none is.
double period_of(const RecordedTrial& trial);

}  // namespace tissued::core
