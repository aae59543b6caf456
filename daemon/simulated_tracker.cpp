#include "daemon/simulated_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tissued::daemon {
namespace {

constexpr double kMeanGap = 0.1;  // s, of an occlusion
constexpr std::uint64_t kFirstStamp_ns = 1'000'000'000;

protocol::Name wire_name(const std::string& name) {
  const auto packed = protocol::Name::from(name);
  if (!packed) throw std::runtime_error("`" + name + "` cannot be sent: 1 to 24 printable ASCII characters can");
  return *packed;
}

// rad, of R = Rx(x) Ry(y) Rz(z), as the stream has rotations.
std::array<double, 3> euler_xyz(const core::Mat3& r) {
  return {std::atan2(-r(1, 2), r(2, 2)), std::asin(std::clamp(r(0, 2), -1.0, 1.0)), std::atan2(-r(0, 1), r(0, 0))};
}

core::SimulatorOptions open_loop(const TrackerSimulation& simulation) {
  core::SimulatorOptions options;
  options.kind = "admm";
  options.solver.time_step = 1.0 / simulation.rate_hz;
  options.solver.iterations = simulation.iterations;
  return options;
}

}  // namespace

SimulatedTracker::SimulatedTracker(const core::Scene& truth, const core::RigidTransform& tissue_from_tracker,
                                   const TrackerSimulation& simulation,
                                   std::span<const std::optional<core::ImagePlane>> images)
    : simulation_(simulation),
      tracker_from_tissue_(tissue_from_tracker.inverse()),
      tissue_(core::make_simulator(truth, open_loop(simulation))),
      occluded_(truth.markers.size(), 0),
      random_(simulation.seed) {
  observation_.resize_for(truth);
  observation_.dt = 1.0 / simulation.rate_hz;
  place_markers();
  bool fits = true;
  for (const core::Pad& pad : truth.pads) fits &= frame_.objects.push_back({wire_name(pad.name), {}, {}});
  add_scripts(images);
  for (const core::Marker& marker : truth.markers)
    fits &= frame_.markers.push_back({wire_name(marker.name), {}, false});
  for (const core::Target& target : truth.targets) fits &= frame_.truth.push_back({wire_name(target.name), {}});
  if (!fits) throw std::runtime_error("a tracker frame holds 32 pads, 128 markers and 64 targets; the scene has more");
}

void SimulatedTracker::add_scripts(std::span<const std::optional<core::ImagePlane>> images) {
  const core::Scene& scene = tissue_->scene();
  for (const ScriptedProbe& scripted : simulation_.probes) {
    const auto found = std::find_if(scene.probes.begin(), scene.probes.end(),
                                    [&](const core::Probe& probe) { return probe.name == scripted.name; });
    if (found == scene.probes.end()) throw std::runtime_error("the bundle has no probe `" + scripted.name + "`");
    const auto probe = static_cast<std::size_t>(found - scene.probes.begin());
    scripts_.push_back({probe, frame_.objects.size(),
                        ProbeScript(scene, found->shape, probe < images.size() ? images[probe] : std::nullopt,
                                    scripted.moves, simulation_.probe_depth, simulation_.probe_seconds)});
    if (!frame_.objects.push_back({wire_name(scripted.name), {}, {}}))
      throw std::runtime_error("a tracker frame holds 32 pads and probes; the scene has more");
  }
}

void SimulatedTracker::place_markers() {
  const core::Scene& scene = tissue_->scene();
  const core::SurfaceGroup* skin = scene.mesh.find_surface(scene.skin_surface);
  for (const core::Marker& marker : scene.markers) {
    const core::Vec3 glued = marker.rest + gaussian(simulation_.placement_error);
    markers_.push_back(core::locate_on_surface(scene.mesh, skin->triangles, glued));
  }
}

const protocol::TrackerFrame& SimulatedTracker::next() {
  const double time = static_cast<double>(frame_.frame_number) / simulation_.rate_hz;
  ++frame_.frame_number;
  frame_.stamp_ns = kFirstStamp_ns + static_cast<std::uint64_t>(std::llround(time * 1e9));
  move_pads(time);
  move_probes(time);
  tissue_->step(observation_);
  see_markers();
  for (std::size_t i = 0; i < frame_.truth.size(); ++i) {
    frame_.truth[i].position = in_tracker(tissue_->target(static_cast<int>(i)).position);
  }
  return frame_;
}

void SimulatedTracker::move_pads(double time) {
  const std::vector<core::Pad>& pads = tissue_->scene().pads;
  for (std::size_t i = 0; i < pads.size(); ++i) {
    const double share = push_share(simulation_.pattern, i, pads.size(), time, simulation_.period);
    core::PadInput& input = observation_.pads[i];
    input.kind = core::PadInput::Kind::pose;
    input.center = pads[i].center + share * simulation_.push * pads[i].direction;
    frame_.objects[i].position = in_tracker(input.center);
  }
}

void SimulatedTracker::move_probes(double time) {
  for (const Script& script : scripts_) {
    core::ProbeInput& input = observation_.probes[script.probe];
    input.seen = true;
    input.tissue_T_probe = script.motion.at(time);
    const core::RigidTransform tracker_T_probe = tracker_from_tissue_ * input.tissue_T_probe;
    protocol::TrackedObject& object = frame_.objects[script.object];
    object.position = in_tracker(input.tissue_T_probe.translation);
    object.rotation_rad = euler_xyz(tracker_T_probe.rotation);
  }
}

// Occlusion is a chain of two states whose stationary share is `dropout`; the dice fall for every marker in every
// frame, so that the noise does not depend on what is seen.
void SimulatedTracker::see_markers() {
  const double leave = std::min(1.0, 1.0 / (kMeanGap * simulation_.rate_hz));
  const double share = simulation_.dropout;
  const double enter = share < 1.0 ? std::min(1.0, leave * share / (1.0 - share)) : 1.0;
  std::uniform_real_distribution<double> dice(0.0, 1.0);
  const core::NodeField& nodes = tissue_->positions();
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    const bool turns = dice(random_) < (occluded_[i] != 0 ? leave : enter);
    if (share >= 1.0) {
      occluded_[i] = 1;
    } else if (turns) {
      occluded_[i] ^= 1;
    }
    core::Vec3 position = gaussian(simulation_.noise);
    for (std::size_t a = 0; a < 4; ++a) {
      position += markers_[i].weights[a] * nodes.row(markers_[i].nodes[a]).head<3>().transpose();
    }
    frame_.markers[i].occluded = occluded_[i] != 0;
    frame_.markers[i].position = occluded_[i] != 0 ? std::array<double, 3>{} : in_tracker(position);
  }
}

core::Vec3 SimulatedTracker::gaussian(double standard_deviation) {
  const double x = normal_(random_), y = normal_(random_), z = normal_(random_);
  return standard_deviation * core::Vec3(x, y, z);
}

std::array<double, 3> SimulatedTracker::in_tracker(const core::Vec3& tissue_position) const {
  const core::Vec3 p = tracker_from_tissue_(tissue_position);
  return {p.x(), p.y(), p.z()};
}

}  // namespace tissued::daemon
