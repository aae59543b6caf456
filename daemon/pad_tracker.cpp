#include "daemon/pad_tracker.hpp"

#include <Eigen/Geometry>

namespace tissued::daemon {

namespace {

using Kind = core::PadInput::Kind;

constexpr double kRestForce = 0.05;  // N; the noise of a force sensor, not a push

}  // namespace

PadTracker::PadTracker(const std::vector<core::Pad>& pads, double rest_tolerance, double placement_sd,
                       bool learn_offsets)
    : rest_tolerance_(rest_tolerance),
      // A registration fitted to markers that were placed no better than this is off by as much.
      coarse_tolerance_(rest_tolerance + 3.0 * placement_sd),
      learn_offsets_(learn_offsets) {
  for (const auto& pad : pads) {
    State state;
    state.rest_center = pad.center;
    pads_.push_back(state);
  }
}

void PadTracker::begin_frame() {
  for (auto& pad : pads_) pad.pose_seen = pad.force_seen = false;
}

void PadTracker::restart() {
  for (auto& pad : pads_) pad.pushing = false;
}

void PadTracker::see_pose(int index, const core::Vec3& position, const core::Mat3& rotation) {
  State& pad = pads_[index];
  pad.pose_seen = true;
  pad.position = position;
  pad.rotation = rotation;
}

void PadTracker::see_force(int index, const core::Vec3& force) {
  State& pad = pads_[index];
  pad.force_seen = true;
  pad.force = force;
}

bool PadTracker::at_rest(const core::RigidTransform& tissue_from_tracker, bool registered) const {
  for (const auto& pad : pads_) {
    if (!at_rest(pad, tissue_from_tracker, registered)) return false;
  }
  return true;
}

bool PadTracker::at_rest(const State& pad, const core::RigidTransform& tissue_from_tracker, bool registered) const {
  if (!pad.pose_seen) return pad.force_seen ? pad.force.norm() <= kRestForce : !pad.pushing;
  if (learn_offsets_ && pad.rest_samples > 0) {
    return (pad.position - pad.position_sum / pad.rest_samples).norm() <= rest_tolerance_;
  }
  if (!registered) return true;
  const double distance = (tissue_from_tracker(pad.position) - pad.rest_center).norm();
  return distance <= (learn_offsets_ ? coarse_tolerance_ : rest_tolerance_);
}

void PadTracker::learn_rest(int max_samples) {
  for (auto& pad : pads_) {
    if (!pad.pose_seen || pad.rest_samples >= max_samples) continue;
    ++pad.rest_samples;
    pad.position_sum += pad.position;
    const Eigen::Vector4d orientation = Eigen::Quaterniond(pad.rotation).coeffs();
    // q and -q are the same rotation; only like signs may be averaged.
    pad.orientation_sum += pad.orientation_sum.dot(orientation) < 0.0 ? Eigen::Vector4d(-orientation) : orientation;
  }
}

int PadTracker::finish_frame(double elapsed, bool whole, const core::RigidTransform& tissue_from_tracker,
                             bool registered, std::span<core::PadInput> inputs) {
  int missing = 0;
  for (std::size_t i = 0; i < pads_.size(); ++i) {
    State& pad = pads_[i];
    pad.pushing = !at_rest(pad, tissue_from_tracker, registered);
    advance(pad, elapsed, whole);
    inputs[i] = input_of(pad, tissue_from_tracker);
    if (pad.unseen > 0.0 && (pad.kind != Kind::absent || pad.pushing)) ++missing;
  }
  return missing;
}

void PadTracker::advance(State& pad, double elapsed, bool whole) const {
  if (pad.pose_seen) {
    pad.kind = Kind::pose;
    pad.unseen = 0.0;
    return;
  }
  pad.unseen += elapsed;
  const bool hold_is_over = whole && pad.unseen > kHold;
  // A force beside a pose that was seen a moment ago does not turn the pad into a force.
  if (pad.force_seen && (pad.kind != Kind::pose || hold_is_over)) {
    pad.kind = Kind::force;
    pad.unseen = 0.0;
  } else if (hold_is_over) {
    pad.kind = Kind::absent;
  }
}

core::PadInput PadTracker::input_of(const State& pad, const core::RigidTransform& tissue_from_tracker) const {
  core::PadInput input;
  input.kind = pad.kind;
  if (pad.kind == Kind::force) input.force = tissue_from_tracker.rotation * pad.force;
  if (pad.kind != Kind::pose) return input;
  const core::Mat3& r = tissue_from_tracker.rotation;
  if (pad.force_seen) input.measured_force = r * pad.force;
  core::Mat3 rest_rotation = core::Mat3::Identity();  // never seen at rest: its axes are taken to be the tracker's
  input.center = tissue_from_tracker(pad.position);
  if (pad.rest_samples > 0) {
    rest_rotation = Eigen::Quaterniond(pad.orientation_sum.normalized()).toRotationMatrix();
    if (learn_offsets_) input.center = pad.rest_center + r * (pad.position - pad.position_sum / pad.rest_samples);
  }
  input.rotation = r * (pad.rotation * rest_rotation.transpose()) * r.transpose();
  return input;
}

}  // namespace tissued::daemon
