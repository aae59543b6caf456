#include "daemon/probe_tracker.hpp"

namespace tissued::daemon {

void ProbeTracker::begin_frame() {
  for (State& probe : probes_) probe.seen = false;
}

void ProbeTracker::see_pose(int index, const core::RigidTransform& tracker_T_probe) {
  State& probe = probes_[static_cast<std::size_t>(index)];
  probe.seen = true;
  probe.tracker_T_probe = tracker_T_probe;
}

int ProbeTracker::finish_frame(double elapsed, bool whole, const core::RigidTransform& tissue_from_tracker,
                               std::span<core::ProbeInput> inputs) {
  int held = 0;
  for (std::size_t i = 0; i < probes_.size(); ++i) {
    State& probe = probes_[i];
    probe.unseen = probe.seen ? 0.0 : probe.unseen + elapsed;
    probe.present = probe.seen || (probe.present && (!whole || probe.unseen <= kHold));
    held += probe.present && !probe.seen ? 1 : 0;
    inputs[i].seen = probe.present;
    inputs[i].tissue_T_probe = tissue_from_tracker * probe.tracker_T_probe;
  }
  return held;
}

}  // namespace tissued::daemon
