#include "daemon/session_export.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <stdexcept>

#include "daemon/frame_joiner.hpp"
#include "daemon/recorded_config.hpp"
#include "protocol/file_content.hpp"
#include "protocol/nexus_csv.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Position = std::array<double, 3>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMargin = 0.5, kPause = 1.0;    // s of rest: around a push; between two
constexpr std::size_t kHeldOut = 4;              // one push in so many
constexpr std::size_t kMostFrames = 10'000'000;  // a day at 100 Hz; a stamp that is wrong must not ask for more

// What one tracker frame says, by names.
struct LiveFrame {
  double time = 0.0;                                           // s, tracker's clock or ours
  std::vector<std::pair<std::size_t, Position>> seen, forces;  // (label or pad, mm or N)
};

class FrameReader {
 public:
  FrameReader(const config::DaemonConfig& config, const protocol::Trial& trial) : joiner_(config) {
    for (std::size_t label = 0; label < trial.labels.size(); ++label) labels_[trial.labels[label]] = label;
    for (std::size_t pad = 0; pad < trial.devices.size(); ++pad) pads_[trial.devices[pad]] = pad;
  }

  void take(const protocol::SessionRecord& record) {
    using protocol::SessionRecordKind;
    if (record.kind == SessionRecordKind::tracker_datagram) keep(joiner_.add(record.body, record.stamp_ns));
    if (record.kind == SessionRecordKind::deadline) keep(joiner_.flush_if_due(record.stamp_ns));
  }
  std::vector<LiveFrame> finish() {
    keep(joiner_.flush_if_due(std::numeric_limits<std::uint64_t>::max()));
    return std::move(frames_);
  }

 private:
  void keep(std::span<const protocol::TrackerFrame> frames) {
    for (const protocol::TrackerFrame& frame : frames) {
      LiveFrame live;
      live.time = static_cast<double>(frame.stamp_ns.value_or(frame.receive_ns)) * 1e-9;
      for (const auto& marker : frame.markers)
        if (!marker.occluded) add(labels_, marker.name, marker.position, live.seen);
      for (const auto& object : frame.objects) add(labels_, object.name, object.position, live.seen);
      for (const auto& truth : frame.truth) add(labels_, truth.name, truth.position, live.seen);
      for (const auto& force : frame.forces) add(pads_, force.name, force.force, live.forces);
      frames_.push_back(std::move(live));
    }
  }
  static void add(const std::map<std::string, std::size_t, std::less<>>& table, const protocol::Name& name,
                  const Position& value, std::vector<std::pair<std::size_t, Position>>& out) {
    if (const auto found = table.find(name.view()); found != table.end()) out.emplace_back(found->second, value);
  }

  FrameJoiner joiner_;
  std::map<std::string, std::size_t, std::less<>> labels_, pads_;
  std::vector<LiveFrame> frames_;
};

void name_columns(const config::DaemonConfig& config, protocol::Trial& trial) {
  const core::Scene& scene = config.bundle.scene;
  const auto add = [&](const std::string& name) {
    trial.add_label(config.bundle.subject.empty() ? name : config.bundle.subject + ":" + name);
  };
  for (const core::Marker& marker : scene.markers) add(marker.name);
  for (const std::string& name : config.unused_markers) add(name);
  for (const core::Pad& pad : scene.pads) {
    add(pad.name);
    trial.devices.push_back(pad.name);
  }
  for (const core::Target& target : scene.targets) add(target.name);
}

// Hz: the bundle's, where the frames keep it; else what their median interval says.
double rate_of(const std::vector<LiveFrame>& frames, double nominal) {
  constexpr double kTolerance = 0.02;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i].time > frames[i - 1].time) intervals.push_back(frames[i].time - frames[i - 1].time);
  if (intervals.empty()) return nominal;
  std::nth_element(intervals.begin(), intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2),
                   intervals.end());
  const double rate = 1.0 / intervals[intervals.size() / 2];
  return std::abs(rate / nominal - 1.0) < kTolerance ? nominal : std::round(rate * 10.0) / 10.0;
}

// Tracker clocks may begin anew: from there on time goes on a second later.
void make_ascending(std::vector<LiveFrame>& frames) {
  double shift = 0.0, before = frames.front().time;
  for (LiveFrame& frame : frames) {
    constexpr double kLongest = 3600.0;  // s
    if (frame.time + shift < before || frame.time + shift > before + kLongest) shift = before + 1.0 - frame.time;
    frame.time += shift;
    before = frame.time;
  }
}

void fill(const std::vector<LiveFrame>& frames, protocol::Trial& trial) {
  const double begin = frames.front().time;
  const double last = std::round((frames.back().time - begin) * trial.rate_hz);
  if (!(last < static_cast<double>(kMostFrames))) throw std::runtime_error("the recording spans more than a day");
  trial.frame_count = static_cast<std::size_t>(last) + 1;
  const std::size_t labels = trial.labels.size(), devices = trial.devices.size();
  trial.positions.assign(trial.frame_count * labels, {kNaN, kNaN, kNaN});
  trial.seen.assign(trial.frame_count * labels, 0);
  trial.forces.assign(trial.frame_count * devices, {kNaN, kNaN, kNaN});
  for (const LiveFrame& frame : frames) {
    const auto at = static_cast<std::size_t>(std::lround((frame.time - begin) * trial.rate_hz));
    for (const auto& [label, position] : frame.seen) {
      trial.positions[at * labels + label] = position;
      trial.seen[at * labels + label] = 1;
    }
    for (const auto& [pad, force] : frame.forces) trial.forces[at * devices + pad] = force;
  }
}

// Frames [begin, end) of the labels and devices that are wanted.
protocol::Trial cut(const protocol::Trial& session, const Stretch& stretch, const std::vector<std::size_t>& labels,
                    const std::vector<std::size_t>& devices) {
  protocol::Trial trial;
  trial.rate_hz = session.rate_hz;
  trial.frame_count = stretch.end - stretch.begin;
  for (const std::size_t label : labels) trial.add_label(session.full_label(label));
  for (const std::size_t device : devices) trial.devices.push_back(session.devices[device]);
  for (std::size_t f = stretch.begin; f < stretch.end; ++f) {
    for (const std::size_t label : labels) {
      trial.positions.push_back(session.position(f, label));
      trial.seen.push_back(session.is_seen(f, label) ? 1 : 0);
    }
    for (const std::size_t device : devices) trial.forces.push_back(session.force(f, device));
  }
  return trial;
}

// Distance of a pad from its rest pose, mm; 0 where it is not seen. Where the tracker's axes are only roughly known, it
// rests where it was seen first.
class PadTravel {
 public:
  PadTravel(const config::DaemonConfig& config, const protocol::Trial& session, std::size_t pad)
      : config_(&config), session_(&session), rest_(config.bundle.scene.pads[pad].center) {
    label_ = session.find_label(config.bundle.scene.pads[pad].name).value();
    if (!config.registration.fit) return;
    for (std::size_t f = 0; f < session.frame_count; ++f)
      if (session.is_seen(f, label_)) {
        rest_ = place(f);
        return;
      }
  }
  std::size_t label() const { return label_; }
  double at(std::size_t frame) const { return session_->is_seen(frame, label_) ? (place(frame) - rest_).norm() : 0.0; }

 private:
  core::Vec3 place(std::size_t frame) const {
    const Position& p = session_->position(frame, label_);
    return config_->bundle.tissue_from_tracker(core::Vec3(p[0], p[1], p[2]));
  }

  const config::DaemonConfig* config_;
  const protocol::Trial* session_;
  std::size_t label_;
  core::Vec3 rest_;
};

std::vector<PadTravel> travels_of(const config::DaemonConfig& config, const protocol::Trial& session) {
  std::vector<PadTravel> travels;
  for (std::size_t pad = 0; pad < config.bundle.scene.pads.size(); ++pad) travels.emplace_back(config, session, pad);
  return travels;
}

bool any_seen(const protocol::Trial& session, const Stretch& stretch, std::size_t label) {
  for (std::size_t f = stretch.begin; f < stretch.end; ++f)
    if (session.is_seen(f, label)) return true;
  return false;
}

bool any_force(const protocol::Trial& session, const Stretch& stretch, std::size_t device) {
  for (std::size_t f = stretch.begin; f < stretch.end; ++f)
    if (std::isfinite(session.force(f, device)[0])) return true;
  return false;
}

// Markers always; pads that push in it; targets that a sensor has read in it.
protocol::Trial trial_of_push(const config::DaemonConfig& config, const protocol::Trial& session,
                              const Stretch& stretch) {
  std::vector<std::size_t> labels, devices;
  const std::size_t markers = config.bundle.scene.markers.size() + config.unused_markers.size();
  for (std::size_t label = 0; label < markers; ++label) labels.push_back(label);
  const std::vector<PadTravel> travels = travels_of(config, session);
  for (std::size_t pad = 0; pad < travels.size(); ++pad) {
    bool pushes = false;
    for (std::size_t f = stretch.begin; f < stretch.end && !pushes; ++f)
      pushes = travels[pad].at(f) > config.registration.rest_tolerance;
    if (!pushes) continue;
    labels.push_back(travels[pad].label());
    if (any_force(session, stretch, pad)) devices.push_back(pad);
  }
  for (std::size_t label = markers + travels.size(); label < session.labels.size(); ++label)
    if (any_seen(session, stretch, label)) labels.push_back(label);
  return cut(session, stretch, labels, devices);
}

void copy_mesh(const config::Bundle& bundle, const fs::path& out) {
  const fs::path relative = fs::relative(bundle.mesh_file, bundle.folder);
  fs::create_directories((out / relative).parent_path());
  // TetGen's meshes are several files of one stem.
  for (const auto& entry : fs::directory_iterator(bundle.mesh_file.parent_path()))
    if (entry.path().stem() == bundle.mesh_file.stem() && entry.path().extension() != ".json" &&
        entry.path().extension() != ".csv")
      fs::copy_file(entry.path(), (out / relative).parent_path() / entry.path().filename(),
                    fs::copy_options::overwrite_existing);
}

void write_bundle(const config::Bundle& bundle, const fs::path& out, const ExportReport& report) {
  json document = json::parse(protocol::read_file_content(bundle.folder / "bundle.json"));
  document["name"] = bundle.scene.name;
  document["trials"] = report.trials;
  document["held_out"] = report.held_out;
  document.erase("trial");
  protocol::write_file_content(out / "bundle.json", document.dump(1) + "\n");
}

}  // namespace

protocol::Trial trial_of_session(const config::DaemonConfig& config, RecordingReader& reader, ExportReport& report) {
  protocol::Trial trial;
  name_columns(config, trial);
  FrameReader frames(config, trial);
  while (const auto record = reader.next()) {
    ++report.records;
    frames.take(*record);
    if (record->kind == protocol::SessionRecordKind::lost)
      report.lost += protocol::read_number(record->body).value_or(0);
  }
  report.damaged_bytes = reader.damaged_bytes();
  report.torn = reader.torn();
  std::vector<LiveFrame> live = frames.finish();
  report.frames = live.size();
  if (live.empty()) throw std::runtime_error("no tracker frame was recorded");
  if (std::ranges::all_of(live, [](const LiveFrame& frame) { return frame.seen.empty() && frame.forces.empty(); }))
    throw std::runtime_error("none of the names that the tracker sent is a marker, pad or target of " +
                             config.bundle.scene.name);
  make_ascending(live);
  report.seconds = live.back().time - live.front().time;
  trial.rate_hz = rate_of(live, config.bundle.scene.rate);
  fill(live, trial);
  return trial;
}

std::vector<Stretch> find_pushes(const config::DaemonConfig& config, const protocol::Trial& session) {
  const std::vector<PadTravel> travels = travels_of(config, session);
  const auto margin = static_cast<std::size_t>(std::lround(kMargin * session.rate_hz));
  const auto pause = static_cast<std::size_t>(std::lround(kPause * session.rate_hz));
  std::vector<Stretch> pushes;
  std::size_t end = 0;  // of the newest push, without its margin
  for (std::size_t f = 0; f < session.frame_count; ++f) {
    const bool away = std::ranges::any_of(
        travels, [&](const PadTravel& travel) { return travel.at(f) > config.registration.rest_tolerance; });
    if (!away) continue;
    if (pushes.empty() || f > end + pause) pushes.push_back({f - std::min(f, margin), 0});
    end = f + 1;
    pushes.back().end = std::min(end + margin, session.frame_count);
  }
  if (pushes.empty()) pushes.push_back({0, session.frame_count});
  return pushes;
}

ExportReport export_session(const fs::path& file, const fs::path& bundle, const fs::path& out) {
  RecordingReader reader(file);
  const config::DaemonConfig recorded = recorded_config(reader, file, bundle);
  // All markers that the bundle knows, whichever were chosen then, by the names that the tracker gave them.
  config::DaemonConfig config = config::config_for_bundle(recorded.bundle.folder);
  config.tracker = recorded.tracker;
  config.registration = recorded.registration;
  if (fs::exists(out / "bundle.json")) throw std::runtime_error(out.string() + ": holds a bundle already");
  ExportReport report;
  const protocol::Trial session = trial_of_session(config, reader, report);
  fs::create_directories(out);
  const std::vector<Stretch> pushes = find_pushes(config, session);
  for (std::size_t k = 0; k < pushes.size(); ++k) {
    char name[32];
    std::snprintf(name, sizeof name, "live-%03zu", k + 1);
    protocol::write_nexus_csv(trial_of_push(config, session, pushes[k]), out / (std::string(name) + ".csv"));
    (k % kHeldOut == kHeldOut - 1 ? report.held_out : report.trials).emplace_back(name);
  }
  copy_mesh(config.bundle, out);
  write_bundle(config.bundle, out, report);
  return report;
}

}  // namespace tissued::daemon
