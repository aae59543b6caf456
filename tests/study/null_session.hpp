// A session in which no physics is missing and no measurement is at fault: what is wrong are the numbers of the assumed
// physics, the places of markers, noise, gaps, and the size of the elements. Whatever a diagnosis finds in it beside
// other numbers is a false alarm.
#pragma once

#include <cstdint>
#include <string>

#include "core/diagnosis/session.hpp"

namespace tissued::study {

struct NullSession {
  std::uint64_t seed = 0;
  int redraws = 0;  // of bodies without room for a pad, or whose truth has no equilibrium that Newton finds
  std::string shape;
  core::RecordedSession session;
  double youngs_modulus = 0.0, poissons_ratio = 0.0;  // kPa; true, where session.scene has the assumed ones
  double marker_offset = 0.0;                         // mm per axis, to which markers are placed
  double missing = 0.0;                               // share of the markers' frames that are gaps
  bool has_force = false, has_targets = false;        // something of them is seen
  int frames = 0;                                     // of the trials that are fitted
};

// The truth is solved by quadratic elements of half the size on the smooth surface through the scene's own nodes.
NullSession draw_null(std::uint64_t seed);

}  // namespace tissued::study
