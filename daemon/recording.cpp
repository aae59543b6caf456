#include "daemon/recording.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "protocol/c3d.hpp"
#include "protocol/nexus_csv.hpp"

namespace tissued::daemon {
namespace {

constexpr double kHoldTolerance = 1e-3;    // mm
constexpr double kRestTolerance = 0.2;     // mm
constexpr std::size_t kSettlingShare = 5;  // one part in five of the hold is left out

std::array<double, 3> to_array(const core::Vec3& v) { return {v.x(), v.y(), v.z()}; }

protocol::Name wire_name(const std::string& name) {
  const auto packed = protocol::Name::from(name);
  if (!packed) throw std::runtime_error("`" + name + "` cannot be sent: 1 to 24 printable ASCII characters can");
  return *packed;
}

}  // namespace

protocol::Trial read_trial(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".csv") return protocol::read_nexus_csv(path);
  if (extension == ".c3d") return protocol::read_c3d(path);
  throw protocol::FileError(path.string(), 0, "not a recording: .csv (Nexus) and .c3d are read");
}

std::optional<std::size_t> find_label(const config::Bundle& bundle, const protocol::Trial& trial,
                                      const std::string& name) {
  if (!bundle.subject.empty()) {
    if (const auto found = trial.find_label(bundle.subject + ':' + name)) return found;
  }
  return trial.find_label(name);
}

Recording::Recording(const config::Bundle& bundle, const config::TrialInfo& info, protocol::Trial trial)
    : bundle_(bundle), info_(info), trial_(std::move(trial)) {
  find_columns();
  if (markers_.empty() && pads_.empty()) {
    throw std::runtime_error(trial_.file + ": holds no marker and no pad of the bundle " + bundle_.scene.name);
  }
  if (trial_.frame_count == 0) throw std::runtime_error(trial_.file + ": holds no frames");
  find_hold();
  find_opening_rest();
}

void Recording::find_columns() {
  const auto find_all = [&](const auto& entries, std::vector<Column>& columns) {
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (const auto label = find_label(bundle_, trial_, entries[i].name))
        columns.push_back({*label, i, wire_name(entries[i].name)});
    }
  };
  find_all(bundle_.scene.markers, markers_);
  find_all(bundle_.scene.pads, pads_);
  find_all(bundle_.scene.targets, targets_);
  for (std::size_t i = 0; i < bundle_.scene.pads.size(); ++i) {
    const std::string& pad = bundle_.scene.pads[i].name;
    if (const auto device = trial_.find_device(pad)) forces_.push_back({*device, i, wire_name(pad)});
  }
}

void Recording::find_hold() {
  std::vector<double> shortfall(trial_.frame_count, 0.0);  // mm, of the pad that is furthest from its largest push
  double largest_push = 0.0;
  for (const Column& pad : pads_) {
    const core::Vec3& rest = bundle_.scene.pads[pad.entry].center;
    std::vector<double> push(trial_.frame_count, 0.0);
    for (std::size_t i = 0; i < push.size(); ++i) {
      if (!trial_.is_seen(i, pad.source)) continue;
      push[i] = (bundle_.tissue_from_tracker(position(i, pad.source)) - rest).norm();
    }
    const double most = *std::ranges::max_element(push);
    for (std::size_t i = 0; i < push.size(); ++i) shortfall[i] = std::max(shortfall[i], most - push[i]);
    largest_push = std::max(largest_push, most);
    pushes_.push_back({pad.entry, most});
  }
  if (largest_push <= kRestTolerance) return;
  for (std::size_t i = 0; i < shortfall.size(); ++i) {
    if (shortfall[i] <= kHoldTolerance) hold_.push_back(i);
  }
  hold_.erase(hold_.begin(), hold_.begin() + static_cast<std::ptrdiff_t>(hold_.size() / kSettlingShare));
}

void Recording::find_opening_rest() {
  opening_rest_ = trial_.frame_count;
  if (info_.held_until_frame > 0) {
    opening_rest_ = std::min(opening_rest_, static_cast<std::size_t>(info_.held_until_frame));
  }
  for (const Column& pad : pads_) {
    const auto moved = [&](std::size_t i) {
      return trial_.is_seen(i, pad.source) &&
             (position(i, pad.source) - position(0, pad.source)).norm() > kRestTolerance;
    };
    std::size_t still = 0;
    while (still < opening_rest_ && !moved(still)) ++still;
    opening_rest_ = std::max<std::size_t>(still, 1);
  }
}

core::Vec3 Recording::position(std::size_t index, std::size_t label) const {
  const auto& p = trial_.position(index, label);
  return {p[0], p[1], p[2]};
}

bool Recording::fill(std::size_t index, const RecordingItems& items, protocol::TrackerFrame& frame) const {
  frame.objects.clear();
  frame.markers.clear();
  frame.forces.clear();
  frame.truth.clear();
  bool fits = true;
  for (const Column& pad : pads_) {
    if (!trial_.is_seen(index, pad.source)) continue;
    fits &= frame.objects.push_back({pad.name, trial_.position(index, pad.source), {}});
  }
  for (const Column& marker : markers_) {
    const auto& wanted = items.marker_set;
    if (wanted != nullptr && std::ranges::count(wanted->markers, bundle_.scene.markers[marker.entry].name) == 0) {
      continue;
    }
    const bool seen = trial_.is_seen(index, marker.source);
    const auto position = seen ? trial_.position(index, marker.source) : std::array<double, 3>{};
    fits &= frame.markers.push_back({marker.name, position, !seen});
  }
  for (const Column& device : forces_) {
    const auto& force = trial_.force(index, device.source);
    const bool known = std::ranges::all_of(force, [](double f) { return std::isfinite(f); });
    if (items.pad_forces && known) fits &= frame.forces.push_back({device.name, force});
  }
  for (const Column& column : targets_) {
    const auto position = target(index, column.entry);
    if (items.truth && position) fits &= frame.truth.push_back({column.name, to_array(*position)});
  }
  return fits;
}

std::optional<core::Vec3> Recording::target(std::size_t index, std::size_t target) const {
  const auto column = std::ranges::find(targets_, target, &Column::entry);
  if (column == targets_.end() || !trial_.is_seen(index, column->source)) return std::nullopt;
  return position(index, column->source);
}

}  // namespace tissued::daemon
