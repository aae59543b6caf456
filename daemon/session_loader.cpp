#include "daemon/session_loader.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>

#include "core/rest_calibration.hpp"
#include "daemon/recording.hpp"
#include "daemon/scene_loader.hpp"

namespace tissued::daemon {

namespace {

// Reads labels of one trial by the names that the bundle knows.
class TrialColumns {
 public:
  TrialColumns(const config::Bundle& bundle, const protocol::Trial& trial) : bundle_(&bundle), trial_(&trial) {}

  std::optional<std::size_t> label(const std::string& name) const { return find_label(*bundle_, *trial_, name); }
  // mm, tissue.
  std::optional<core::Vec3> position(std::size_t frame, std::size_t label) const {
    if (!trial_->is_seen(frame, label)) return std::nullopt;
    const auto& p = trial_->position(frame, label);
    return bundle_->tissue_from_tracker(core::Vec3(p[0], p[1], p[2]));
  }

 private:
  const config::Bundle* bundle_;
  const protocol::Trial* trial_;
};

void read_pads(const core::Scene& scene, const protocol::Trial& file, const TrialColumns& columns,
               core::RecordedTrial& trial) {
  trial.pads.assign(file.frame_count, std::vector<core::PadInput>(scene.pads.size()));
  for (std::size_t p = 0; p < scene.pads.size(); ++p) {
    const auto label = columns.label(scene.pads[p].name);
    if (!label) continue;
    core::Vec3 last = scene.pads[p].center;
    for (std::size_t f = 0; f < file.frame_count; ++f) {
      last = columns.position(f, *label).value_or(last);
      trial.pads[f][p].kind = core::PadInput::Kind::pose;
      trial.pads[f][p].center = last;
    }
  }
}

// Displacements of the points of that kind, from channel `first` on.
template <typename Points>
void read_points(const Points& points, const protocol::Trial& file, const TrialColumns& columns, int first,
                 core::RecordedTrial& trial) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto label = columns.label(points[i].name);
    if (!label) continue;
    for (std::size_t f = 0; f < file.frame_count; ++f)
      if (const auto position = columns.position(f, *label))
        trial.seen.row(static_cast<Eigen::Index>(f)).template segment<3>(first + 3 * static_cast<int>(i)) =
            (*position - points[i].rest).transpose();
  }
}

void read_forces(const config::Bundle& bundle, const core::Scene& scene, const protocol::Trial& file,
                 const core::Channels& channels, core::RecordedTrial& trial) {
  for (std::size_t p = 0; p < scene.pads.size(); ++p) {
    const auto device = file.find_device(scene.pads[p].name);
    if (!device || trial.pads.empty() || trial.pads.front()[p].kind == core::PadInput::Kind::absent) continue;
    for (std::size_t f = 0; f < file.frame_count; ++f) {
      const auto& force = file.force(f, *device);
      trial.seen.row(static_cast<Eigen::Index>(f)).segment<3>(channels.of_force(static_cast<int>(p))) =
          (bundle.tissue_from_tracker.rotation * core::Vec3(force[0], force[1], force[2])).transpose();
    }
  }
}

// mm, tracker: the middle one of what was seen of a label in these frames, along each axis.
std::optional<core::Vec3> middle_of(const protocol::Trial& file, std::size_t label, std::size_t frames) {
  std::array<std::vector<double>, 3> seen;
  for (std::size_t f = 0; f < frames; ++f)
    for (std::size_t axis = 0; axis < 3 && file.is_seen(f, label); ++axis)
      seen[axis].push_back(file.position(f, label)[axis]);
  if (seen[0].empty()) return std::nullopt;
  core::Vec3 middle;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    auto& values = seen[static_cast<std::size_t>(axis)];
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    middle[axis] = *half;
  }
  return middle;
}

// Markers of a trial that begins at rest, as displacements from there: single frames of a tracker that starts up, and
// markers that are not quite where the bundle has them, do not matter then. What the bundle knows of the tracker's axes
// is made exact by the markers at rest.
void read_markers_from_rest(const config::Bundle& bundle, const core::Scene& scene, const protocol::Trial& file,
                            const TrialColumns& columns, std::size_t held, core::RecordedTrial& trial) {
  std::vector<core::Vec3> from, to;
  std::vector<std::optional<core::Vec3>> rests;
  for (const core::Marker& marker : scene.markers) {
    const auto label = columns.label(marker.name);
    rests.push_back(label ? middle_of(file, *label, held) : std::nullopt);
    if (!rests.back()) continue;
    from.push_back(bundle.tissue_from_tracker(*rests.back()));
    to.push_back(marker.rest);
  }
  const core::Registration refined = core::register_rigid(from, to);
  core::Mat3 rotation = bundle.tissue_from_tracker.rotation;
  if (refined.determined) rotation = refined.tissue_from_tracker.rotation * rotation;
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    if (!rests[i]) continue;
    const std::size_t label = *columns.label(scene.markers[i].name);
    for (Eigen::Index f = 0; f < trial.seen.rows(); ++f) {
      const auto frame = static_cast<std::size_t>(f);
      if (!file.is_seen(frame, label)) continue;
      const auto& p = file.position(frame, label);
      trial.seen.row(f).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          (rotation * (core::Vec3(p[0], p[1], p[2]) - *rests[i])).transpose();
    }
  }
}

core::RecordedTrial read_recorded(const config::Bundle& bundle, const core::Scene& scene,
                                  const config::TrialInfo& info) {
  protocol::Trial file = read_trial(info.file);
  if (file.frame_count == 0) throw std::runtime_error(info.file.string() + ": holds no frames");
  const TrialColumns columns(bundle, file);
  const core::Channels channels = core::channels_of(scene);
  core::RecordedTrial trial;
  trial.name = info.name;
  const std::size_t held = static_cast<std::size_t>(info.held_until_frame);
  if (held >= file.frame_count)
    throw std::runtime_error(info.file.string() + ": has " + std::to_string(file.frame_count) +
                             " frames, and held_until_frame is " + std::to_string(held));
  if (info.end_frame) file.frame_count = std::min(file.frame_count, static_cast<std::size_t>(*info.end_frame));
  for (std::size_t f = 0; f < file.frame_count; ++f) trial.time.push_back(static_cast<double>(f) / file.rate_hz);
  trial.seen.setConstant(static_cast<Eigen::Index>(file.frame_count), channels.count(),
                         std::numeric_limits<double>::quiet_NaN());
  if (bundle.dynamic)
    trial.motion = core::Motion{static_cast<double>(held) / file.rate_hz, info.start == "straight", info.loads};
  read_pads(scene, file, columns, trial);
  if (bundle.dynamic && held > 0)
    read_markers_from_rest(bundle, scene, file, columns, held, trial);
  else
    read_points(scene.markers, file, columns, channels.of_marker(0), trial);
  read_points(scene.targets, file, columns, channels.of_target(0), trial);
  read_forces(bundle, scene, file, channels, trial);
  return trial;
}

}  // namespace

core::RecordedSession load_session(const config::Bundle& bundle) {
  core::RecordedSession session;
  session.scene = load_scene(bundle);
  session.marker_noise = bundle.noise.marker;
  if (bundle.noise.target > 0.0) session.target_noise = bundle.noise.target;
  if (bundle.noise.force > 0.0) session.force_noise = bundle.noise.force;
  for (const config::TrialInfo& info : bundle.trials)
    (info.held_out ? session.held_out : session.trials).push_back(read_recorded(bundle, session.scene, info));
  return session;
}

}  // namespace tissued::daemon
