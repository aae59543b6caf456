#include "daemon/frame_processor.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <exception>
#include <string>

#include "daemon/monotonic_clock.hpp"
#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {

namespace {

using protocol::ValidityReason;

constexpr double kTolerableLag = 0.1;  // mm that a simulated pad or probe may be behind the tracked one
constexpr int kFewestMarkers = 3;      // that tell a motion of the whole body from a turn

core::Vec3 to_vec3(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }
std::array<double, 3> to_array(const core::Vec3& v) { return {v.x(), v.y(), v.z()}; }

core::Mat3 rotation_of(const protocol::TrackedObject& object) {
  using Eigen::AngleAxisd;
  const auto& angle = object.rotation_rad;
  return (AngleAxisd(angle[0], core::Vec3::UnitX()) * AngleAxisd(angle[1], core::Vec3::UnitY()) *
          AngleAxisd(angle[2], core::Vec3::UnitZ()))
      .toRotationMatrix();
}

// Where the simulation has the markers before anything is recorded: under the body's weight, where it has one.
std::vector<core::Vec3> rest_positions(const core::Simulator& simulator) {
  std::vector<core::Vec3> rest;
  for (std::size_t i = 0; i < simulator.scene().markers.size(); ++i)
    rest.push_back(simulator.marker(static_cast<int>(i)));
  return rest;
}

void require_at_most(std::size_t limit, std::size_t count, const char* what) {
  if (count <= limit) return;
  throw core::ModelError("scene has " + std::to_string(count) + " " + what + ", more than the " +
                         std::to_string(limit) + " that fit into a frame");
}

// A frame whose stamp says how many datagrams it has, and not all came.
bool is_partial(const protocol::TrackerFrame& frame) {
  return frame.stamp_ns.has_value() && (frame.completion == protocol::FrameCompletion::superseded ||
                                        frame.completion == protocol::FrameCompletion::deadline);
}

}  // namespace

FrameProcessor::FrameProcessor(core::Simulator& simulator, const config::DaemonConfig& config, Counters& counters)
    : simulator_(simulator),
      counters_(counters),
      names_(simulator.scene(), config.unused_markers),
      clock_(simulator.time_step()),
      pads_(simulator.scene().pads, config.registration.rest_tolerance, config.registration.placement_sd,
            config.registration.fit),
      probes_(simulator.scene().probes.size()),
      images_(config.bundle.probe_images),
      calibration_(rest_positions(simulator), config.registration.placement_sd, simulator.scene().marker_noise,
                   config.bundle.tissue_from_tracker, config.registration.fit),
      fit_(config.registration.fit),
      rest_frames_(config.registration.rest_frames),
      closed_loop_(core::reads_markers(config.simulator)),
      marker_delay_(config.marker_delay),
      marker_correction_(config.marker_correction) {
  const core::Scene& scene = simulator.scene();
  require_at_most(kMaxMarkers, scene.markers.size(), "markers");
  require_at_most(kMaxPads, scene.pads.size(), "pads");
  require_at_most(kMaxTargets, scene.targets.size(), "targets");
  require_at_most(kMaxProbes, scene.probes.size(), "probes");
  seen_.markers.resize(scene.markers.size());
  seen_.marker_seen.resize(scene.markers.size());
  observation_.resize_for(scene);
  // Soft tissue is pushed about by less than its own size.
  core::Vec3 low = scene.mesh.rest.leftCols<3>().colwise().minCoeff();
  core::Vec3 high = scene.mesh.rest.leftCols<3>().colwise().maxCoeff();
  for (const core::Target& target : scene.targets) {
    low = low.cwiseMin(target.rest);
    high = high.cwiseMax(target.rest);
  }
  centre_ = 0.5 * (low + high);
  reach_ = 2.0 * (high - low).norm();
  images_.resize(scene.probes.size());
}

void FrameProcessor::process(const protocol::TrackerFrame& frame, const Answer& previous, Answer& answer,
                             const StepTerms& terms) noexcept {
  if (frame.after_restart) pads_.restart();
  read_names(frame);
  read_late_markers(frame);
  const FrameInterval interval = clock_.advance(frame);
  if (interval.clamped) counters_.add(Count::dt_clamped);
  if (interval.stamp_refused) counters_.add(Count::stamps_refused);
  calibrate(interval.elapsed);
  observe(interval, !is_partial(frame));
  follow_rate();
  observation_.max_iterations = terms.max_iterations;
  observation_.brake = terms.brake;

  const std::uint64_t begin_ns = monotonic_ns();
  const core::StepReport report = simulator_.step(observation_);
  const std::uint64_t step_time_ns = monotonic_ns() - begin_ns;
  counters_.add(Count::frames_stepped);
  pressed_by_probe_ = report.contacts > 0;
  if (late_) {
    const auto too_late = static_cast<std::uint64_t>(report.markers_too_late);
    counters_.add(Count::markers_too_late, too_late);
    counters_.add(Count::delayed_markers, static_cast<std::uint64_t>(markers_fed_) - too_late);
  }

  answer.has_frame = true;
  answer.tracker_frame = frame.frame_number;
  answer.stamp_ns = frame.stamp_ns;
  answer.receive_ns = frame.receive_ns;
  answer.delay_ns = static_cast<std::uint64_t>(std::llround(1e9 * interval.delay));
  answer.report = report;
  answer.markers_seen = seen_.marker_count;
  answer.reasons = reasons_of(report, frame, step_time_ns);
  answer.overload = terms.overload;
  if (terms.overload > 0) answer.reasons |= ValidityReason::kOverloaded;
  write_alarm(frame, previous.alarm, report.mismatch, answer.alarm);
  const bool report_finite = std::isfinite(report.primal_residual) && std::isfinite(report.dual_residual) &&
                             std::isfinite(report.innovation_rms) && std::isfinite(report.mismatch.level) &&
                             std::isfinite(report.mismatch.misfit) && report.mismatch.place.allFinite();
  if (!write_estimates(answer) || !report.finite || !report_finite) {
    counters_.add(report.braked ? Count::steps_braked : Count::steps_not_finite);
    mesh_is_of_answer_ = !report.finite;  // else the simulation goes back to the answer's state by itself
    if (report.finite) simulator_.reset();
    answer = previous;
    unsigned reasons = (previous.reasons & ~unsigned{ValidityReason::kStepBraked}) | ValidityReason::kDiverged;
    if (report.braked) reasons |= ValidityReason::kStepBraked;
    answer.reasons = static_cast<std::uint16_t>(reasons);
  } else {
    mesh_is_of_answer_ = true;
  }
  answer.step_time_ns = step_time_ns;
}

// Returns how many names the scene does not have.
template <typename Markers>
std::uint64_t FrameProcessor::read_markers(const Markers& markers) {
  using Kind = NameEntry::Kind;
  std::uint64_t unknown = 0;
  for (const auto& marker : markers) {
    const NameEntry entry = names_.find(marker.name);
    if (entry.kind == Kind::marker && !marker.occluded) {
      seen_.markers[entry.index] = marker_correction_(to_vec3(marker.position));
      seen_.marker_seen[entry.index] = 1;
      ++seen_.marker_count;
    }
    if (entry.kind != Kind::marker && entry.kind != Kind::unused_marker) ++unknown;
  }
  return unknown;
}

void FrameProcessor::read_late_markers(const protocol::TrackerFrame& frame) {
  observation_.marker_age = marker_delay_;
  late_ = false;
  if (seen_.marker_count > 0 || frame.late.markers.empty() || frame.after_restart) return;
  read_markers(frame.late.markers);
  late_ = true;
  if (frame.stamp_ns && frame.late.stamp_ns && *frame.stamp_ns >= *frame.late.stamp_ns) {
    observation_.marker_age += static_cast<double>(*frame.stamp_ns - *frame.late.stamp_ns) * 1e-9;
  } else {
    observation_.marker_age += (frame.frame_number - frame.late.frame_number) * clock_.period();
  }
}

void FrameProcessor::read_names(const protocol::TrackerFrame& frame) {
  using Kind = NameEntry::Kind;
  std::uint64_t unknown = 0;
  std::fill(seen_.marker_seen.begin(), seen_.marker_seen.end(), std::uint8_t{0});
  seen_.truth.fill(std::nullopt);
  seen_.marker_count = 0;
  unknown += read_markers(frame.markers);
  pads_.begin_frame();
  probes_.begin_frame();
  for (const auto& object : frame.objects) {
    const NameEntry entry = names_.find(object.name);
    if (entry.kind == Kind::pad) {
      pads_.see_pose(entry.index, to_vec3(object.position), rotation_of(object));
    } else if (entry.kind == Kind::probe) {
      probes_.see_pose(entry.index, {rotation_of(object), to_vec3(object.position)});
    } else {
      ++unknown;
    }
  }
  for (const auto& force : frame.forces) {
    const NameEntry entry = names_.find(force.name);
    if (entry.kind != Kind::pad) {
      ++unknown;
      continue;
    }
    pads_.see_force(entry.index, to_vec3(force.force));
  }
  for (const auto& truth : frame.truth) {
    const NameEntry entry = names_.find(truth.name);
    if (entry.kind != Kind::target) {
      ++unknown;
      continue;
    }
    seen_.truth[entry.index] = truth.position;
  }
  if (unknown > 0) counters_.add(Count::unknown_names, unknown);
}

void FrameProcessor::calibrate(double elapsed) {
  const bool at_rest = pads_.at_rest(tissue_from_tracker(), registered()) && !pressed_by_probe_;
  if (!rest_gate_.admits(at_rest, elapsed)) return;
  bool newcomer = false;
  for (std::size_t i = 0; i < seen_.markers.size(); ++i) {
    newcomer = newcomer || (seen_.marker_seen[i] && !calibration_.has_offset(static_cast<int>(i)));
  }
  if (calibration_.frames() < rest_frames_ || newcomer) {
    const bool was_registered = registered();
    calibration_.add(seen_.markers, seen_.marker_seen);
    // The registration came from this very frame: only now can be told whether the pads are where pads at rest are.
    if (!was_registered && registered() && !pads_.at_rest(tissue_from_tracker(), true)) {
      calibration_.reset();
      rest_gate_.disturb();
      return;
    }
  }
  pads_.learn_rest(rest_frames_);
  counters_.set(Count::rest_frames, static_cast<std::uint64_t>(calibration_.frames()));
  const double rms_um = calibration_.registration().residual_rms * 1e3;
  counters_.set(Count::registration_rms_um, static_cast<std::uint64_t>(std::lround(std::min(rms_um, 1e9))));
}

void FrameProcessor::observe(const FrameInterval& interval, bool whole) {
  observation_.dt = interval.dt;
  observation_.marker_place_sd = calibration_.place_sd();
  markers_fed_ = 0;
  const bool usable = registered();
  for (std::size_t i = 0; i < seen_.markers.size(); ++i) {
    const auto index = static_cast<int>(i);
    const bool withheld = calibration_.frames() > 0 && !calibration_.has_offset(index);
    if (seen_.marker_seen[i] && withheld) counters_.add(Count::late_markers);
    observation_.marker_seen[i] = usable && seen_.marker_seen[i] && !withheld;
    if (!observation_.marker_seen[i]) continue;
    observation_.markers[i] = calibration_.to_model(index, seen_.markers[i]);
    ++markers_fed_;
  }
  pads_held_ = pads_.finish_frame(interval.elapsed, whole, tissue_from_tracker(), usable, observation_.pads);
  pads_held_ += probes_.finish_frame(interval.elapsed, whole, tissue_from_tracker(), observation_.probes);
  if (pads_held_ > 0) counters_.add(Count::pads_held, static_cast<std::uint64_t>(pads_held_));
  if (!usable) std::fill(observation_.pads.begin(), observation_.pads.end(), core::PadInput{});
  if (!usable) std::fill(observation_.probes.begin(), observation_.probes.end(), core::ProbeInput{});
}

void FrameProcessor::follow_rate() {
  const auto period = clock_.changed_period();
  if (!period) return;
  try {
    simulator_.set_time_step(*period);
    clock_.adopt_period();
    counters_.add(Count::rate_changes);
  } catch (const std::exception&) {
    clock_.keep_period();
    counters_.add(Count::rate_changes_failed);
  }
}

std::uint16_t FrameProcessor::reasons_of(const core::StepReport& report, const protocol::TrackerFrame& frame,
                                         std::uint64_t step_time_ns) const {
  unsigned reasons = 0;
  const auto say = [&reasons](bool holds, ValidityReason reason) {
    if (holds) reasons |= reason;
  };
  say(!report.converged || report.pad_ramp > kTolerableLag, ValidityReason::kNotConverged);
  say(closed_loop_ && report.markers_used == 0, ValidityReason::kNoMarkers);
  say(closed_loop_ && report.markers_used > 0 && report.markers_used < kFewestMarkers, ValidityReason::kFewMarkers);
  say(closed_loop_ && report.markers_used < markers_fed_, ValidityReason::kMarkersRejected);
  say(pads_held_ > 0, ValidityReason::kPadMissing);
  say(!registered(), ValidityReason::kNotRegistered);
  say(is_partial(frame), ValidityReason::kPartialFrame);
  say(static_cast<double>(step_time_ns) * 1e-9 > clock_.period(), ValidityReason::kDeadlineMissed);
  say(report.inverted > 0, ValidityReason::kInvertedElements);
  say(report.mismatch.raised, ValidityReason::kModelMismatch);
  return static_cast<std::uint16_t>(reasons);
}

// Targets and forces, in tracker coordinates. False where a number is not finite.
bool FrameProcessor::write_estimates(Answer& answer) const noexcept {
  const core::Scene& scene = simulator_.scene();
  const core::RigidTransform tracker_from_tissue = tissue_from_tracker().inverse();
  const core::Mat3& r = tracker_from_tissue.rotation;
  bool finite = true;
  answer.targets.clear();
  for (std::size_t i = 0; i < scene.targets.size(); ++i) {
    const core::TargetEstimate estimate = simulator_.target(static_cast<int>(i));
    const core::Mat3 c = r * estimate.covariance * r.transpose();
    // Rotating a variance of nearly zero may leave it a rounding error below.
    const auto variance = [&c](int axis) { return std::max(c(axis, axis), 0.0); };
    const TargetPlace target{to_array(tracker_from_tissue(estimate.position)),
                             {variance(0), c(0, 1), c(0, 2), variance(1), c(1, 2), variance(2)},
                             seen_.truth[i]};
    finite = finite && within_reach(estimate.position) && c.allFinite();
    answer.targets.push_back(target);
  }
  answer.pads.clear();
  for (std::size_t i = 0; i < scene.pads.size(); ++i) {
    if (observation_.pads[i].kind == core::PadInput::Kind::absent) continue;
    const core::Vec3 force = r * simulator_.pad_force(static_cast<int>(i));
    finite = finite && force.allFinite();
    answer.pads.push_back({static_cast<std::uint16_t>(i), to_array(force)});
  }
  return write_probes(answer) && finite;
}

// False where it is not finite, too.
bool FrameProcessor::within_reach(const core::Vec3& position) const noexcept {
  return (position - centre_).norm() <= reach_;
}

// What probes push, in tracker coordinates, and targets in their images. The tracker's pose of a probe is what its
// image belongs to, even while the simulated probe is ramped. False where a number is not finite.
bool FrameProcessor::write_probes(Answer& answer) const noexcept {
  const core::Scene& scene = simulator_.scene();
  const core::Mat3 r = tissue_from_tracker().rotation.transpose();
  bool finite = true;
  answer.probes.resize(scene.probes.size());
  for (std::size_t i = 0; i < scene.probes.size(); ++i) {
    ProbeAnswer& probe = answer.probes[i];
    probe.seen = observation_.probes[i].seen;
    probe.force = {};
    probe.targets.clear();
    if (!probe.seen) continue;
    const core::Vec3 force = r * simulator_.probe_force(static_cast<int>(i));
    probe.force = to_array(force);
    finite = finite && force.allFinite();
    if (!images_[i]) continue;
    for (std::size_t t = 0; t < scene.targets.size(); ++t) {
      const core::TargetEstimate target = simulator_.target(static_cast<int>(t));
      const core::ImagePoint point =
          core::project(*images_[i], observation_.probes[i].tissue_T_probe, target.position, target.covariance);
      finite = finite && point.pixel.allFinite() && point.covariance.allFinite() && std::isfinite(point.distance) &&
               std::isfinite(point.distance_sd);
      probe.targets.push_back(point);
    }
  }
  return finite;
}

void FrameProcessor::write_alarm(const protocol::TrackerFrame& frame, const AlarmAnswer& previous,
                                 const core::MismatchReport& mismatch, AlarmAnswer& alarm) const noexcept {
  alarm = AlarmAnswer{};
  alarm.watching = mismatch.watching;
  alarm.raised = mismatch.raised;
  alarm.level = mismatch.level;
  alarm.misfit = mismatch.misfit;
  alarm.has_place = mismatch.has_place;
  if (mismatch.has_place) alarm.place = to_array(tissue_from_tracker().inverse()(mismatch.place));
  if (!mismatch.raised) return;
  alarm.since_frame = previous.raised ? previous.since_frame : frame.frame_number;
  alarm.since_ns = previous.raised ? previous.since_ns : frame.receive_ns;
}

void FrameProcessor::rest_answer(Answer& answer) const noexcept {
  answer = Answer{};
  answer.report.converged = true;
  write_estimates(answer);
}

bool FrameProcessor::snapshot(const Answer& answer, MeshSnapshot& mesh) const noexcept {
  if (!mesh_is_of_answer_) return false;
  mesh.tracker_frame = answer.tracker_frame;
  mesh.receive_ns = answer.receive_ns;
  const core::RigidTransform tracker_from_tissue = tissue_from_tracker().inverse();
  const core::NodeField& nodes = simulator_.positions();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto node = nodes.row(static_cast<Eigen::Index>(i));
    mesh.positions[i] = to_array(tracker_from_tissue(core::Vec3(node[0], node[1], node[2])));
  }
  return true;
}

}  // namespace tissued::daemon
