#include "daemon/session_loader.hpp"

#include <optional>
#include <stdexcept>

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

core::RecordedTrial read_recorded(const config::Bundle& bundle, const core::Scene& scene,
                                  const config::TrialInfo& info) {
  const protocol::Trial file = read_trial(info.file);
  if (file.frame_count == 0) throw std::runtime_error(info.file.string() + ": holds no frames");
  const TrialColumns columns(bundle, file);
  const core::Channels channels = core::channels_of(scene);
  core::RecordedTrial trial;
  trial.name = info.name;
  for (std::size_t f = 0; f < file.frame_count; ++f) trial.time.push_back(static_cast<double>(f) / file.rate_hz);
  trial.seen.setConstant(static_cast<Eigen::Index>(file.frame_count), channels.count(),
                         std::numeric_limits<double>::quiet_NaN());
  read_pads(scene, file, columns, trial);
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
