#pragma once

#include <span>
#include <vector>

#include "core/probe.hpp"

namespace tissued::daemon {

/// From what frames say about probes to where they are in a step. A probe that is missing stays where it was for kHold,
/// because a lost datagram must not lift it off the skin, and does not touch afterwards. Frames with datagrams missing
/// never lift a probe.
class ProbeTracker {
 public:
  static constexpr double kHold = 0.1;  // s

  explicit ProbeTracker(std::size_t probes) : probes_(probes) {}

  /// A new frame begins; nothing is seen in it yet.
  void begin_frame();
  void see_pose(int probe, const core::RigidTransform& tracker_T_probe);

  /// Fills `inputs` (probes) for this frame, and returns how many probes were not seen and stay as they were.
  /// elapsed: s since the frame before. whole: no datagram of it was lost.
  int finish_frame(double elapsed, bool whole, const core::RigidTransform& tissue_from_tracker,
                   std::span<core::ProbeInput> inputs);

 private:
  struct State {
    bool seen = false;     // in this frame
    bool present = false;  // seen now, or a moment ago
    double unseen = 0.0;   // s since it was last seen
    core::RigidTransform tracker_T_probe;
  };
  std::vector<State> probes_;
};

}  // namespace tissued::daemon
