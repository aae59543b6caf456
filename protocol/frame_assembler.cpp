#include "protocol/frame_assembler.hpp"

#include <algorithm>
#include <utility>

namespace tissued::protocol {

namespace {

constexpr std::uint32_t kHalfRange = 0x80000000U;  // frame numbers less than this ahead, modulo 2^32, are newer

bool contains(const std::vector<Name>& names, const Name& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

template <typename List>
bool has_name(const List& list, const Name& name) {
  return std::any_of(list.begin(), list.end(), [&](const auto& item) { return item.name == name; });
}

AssemblerEvent event_of(FrameCompletion completion) {
  switch (completion) {
    case FrameCompletion::all_parts:
      return AssemblerEvent::frames_all_parts;
    case FrameCompletion::all_names:
      return AssemblerEvent::frames_all_names;
    case FrameCompletion::superseded:
      return AssemblerEvent::frames_superseded;
    case FrameCompletion::deadline:
      break;
  }
  return AssemblerEvent::frames_deadline;
}

}  // namespace

const char* to_string(AssemblerEvent event) {
  switch (event) {
    case AssemblerEvent::datagrams_joined:
      return "datagrams_joined";
    case AssemblerEvent::duplicate_datagrams:
      return "duplicate_datagrams";
    case AssemblerEvent::late_datagrams:
      return "late_datagrams";
    case AssemblerEvent::inconsistent_datagrams:
      return "inconsistent_datagrams";
    case AssemblerEvent::restart_suspects:
      return "restart_suspects";
    case AssemblerEvent::jump_suspects:
      return "jump_suspects";
    case AssemblerEvent::duplicate_items:
      return "duplicate_items";
    case AssemblerEvent::overflowing_items:
      return "overflowing_items";
    case AssemblerEvent::frames_all_parts:
      return "frames_all_parts";
    case AssemblerEvent::frames_all_names:
      return "frames_all_names";
    case AssemblerEvent::frames_superseded:
      return "frames_superseded";
    case AssemblerEvent::frames_deadline:
      return "frames_deadline";
    case AssemblerEvent::frames_missing:
      return "frames_missing";
    case AssemblerEvent::forward_jumps:
      return "forward_jumps";
    case AssemblerEvent::restarts:
      return "restarts";
  }
  return "unknown";
}

FrameAssembler::FrameAssembler(FrameAssemblerConfig config) : config_(std::move(config)) {}

std::span<const TrackerFrame> FrameAssembler::add(const TrackerDatagram& datagram, std::uint64_t receive_ns) {
  ready_count_ = 0;
  switch (place(datagram.frame_number, receive_ns)) {
    case Place::same:
      if (!admit_to_same(datagram)) return {};
      break;
    case Place::newer:
      if (open_) close(FrameCompletion::superseded);
      if (started_) count_gap(datagram.frame_number);
      open(datagram.frame_number, receive_ns);
      break;
    case Place::late:
      tally(AssemblerEvent::late_datagrams);
      keep_late(datagram);
      return {};
    case Place::far_behind:
      tally(AssemblerEvent::restart_suspects);
      return {};
    case Place::far_ahead:
      tally(AssemblerEvent::jump_suspects);
      return {};
    case Place::restart:
      if (open_) close(FrameCompletion::superseded);
      tally(AssemblerEvent::restarts);
      open(datagram.frame_number, receive_ns);
      frame_.after_restart = true;
      late_.markers.clear();
      break;
  }
  join(datagram);
  progress_ns_ = receive_ns;
  behind_run_ = 0;
  ahead_last_.reset();
  if (const auto finished = completion()) close(*finished);
  return std::span(ready_).first(ready_count_);
}

std::span<const TrackerFrame> FrameAssembler::flush_if_due(std::uint64_t now_ns) {
  ready_count_ = 0;
  const auto due = due_ns();
  if (due && now_ns >= *due) close(FrameCompletion::deadline);
  return std::span(ready_).first(ready_count_);
}

std::optional<std::uint64_t> FrameAssembler::due_ns() const {
  if (!open_) return std::nullopt;
  return frame_.receive_ns + config_.deadline_ns;
}

FrameAssembler::Place FrameAssembler::place(std::uint32_t frame_number, std::uint64_t receive_ns) {
  if (!started_) return Place::newer;
  const std::uint32_t ahead = frame_number - frame_.frame_number;
  if (ahead == 0 && open_) return Place::same;
  const bool silent = receive_ns > progress_ns_ && receive_ns - progress_ns_ >= config_.restart_silence_ns;
  if (ahead != 0 && ahead < kHalfRange) {
    const bool jumps = ahead - 1 > config_.reorder_window && !silent;
    return jumps && !confirms_jump(frame_number) ? Place::far_ahead : Place::newer;
  }
  if (silent) return Place::restart;
  if (ahead == 0) return Place::same;
  const std::uint32_t frames_back = 0U - ahead;
  if (confirms_restart(frame_number, frames_back)) return Place::restart;
  return frames_back > config_.reorder_window ? Place::far_behind : Place::late;
}

bool FrameAssembler::confirms_restart(std::uint32_t frame_number, std::uint32_t frames_back) {
  const std::uint32_t step = frame_number - behind_last_;
  if (behind_run_ > 0 && step == 0) return false;  // another datagram of the same frame confirms nothing
  const bool ascending = behind_run_ > 0 && step <= config_.reorder_window;
  behind_run_ = ascending ? behind_run_ + 1 : 1;
  behind_last_ = frame_number;
  return behind_run_ >= (frames_back > config_.reorder_window ? 2 : config_.late_frames_for_restart);
}

bool FrameAssembler::confirms_jump(std::uint32_t frame_number) {
  const std::optional<std::uint32_t> last = std::exchange(ahead_last_, frame_number);
  return last && frame_number != *last && frame_number - *last <= config_.reorder_window;
}

// Whether a datagram of the newest frame may join it; counts why not.
bool FrameAssembler::admit_to_same(const TrackerDatagram& datagram) {
  const auto& stamp = datagram.stamp;
  if (stamp && part_count_ > 0 && (stamp->part_count != part_count_ || stamp->stamp_ns != frame_.stamp_ns)) {
    tally(AssemblerEvent::inconsistent_datagrams);
    return false;
  }
  if (stamp ? parts_.test(stamp->part) : adds_nothing(datagram)) {
    tally(AssemblerEvent::duplicate_datagrams);
    return false;
  }
  if (!open_) {
    tally(AssemblerEvent::late_datagrams);
    keep_late(datagram);
  }
  return open_;
}

bool FrameAssembler::adds_nothing(const TrackerDatagram& datagram) const {
  const auto known = [](const auto& list) { return [&list](const auto& item) { return has_name(list, item.name); }; };
  return std::all_of(datagram.objects.begin(), datagram.objects.end(),
                     [&](const TrackedObject& object) {
                       return has_name(frame_.objects, object.name) || has_name(frame_.markers, object.name);
                     }) &&
         std::all_of(datagram.markers.begin(), datagram.markers.end(), known(frame_.markers)) &&
         std::all_of(datagram.forces.begin(), datagram.forces.end(), known(frame_.forces)) &&
         std::all_of(datagram.truth.begin(), datagram.truth.end(), known(frame_.truth));
}

void FrameAssembler::open(std::uint32_t frame_number, std::uint64_t receive_ns) {
  frame_.frame_number = frame_number;
  frame_.stamp_ns.reset();
  frame_.receive_ns = receive_ns;
  frame_.after_restart = false;
  frame_.objects.clear();
  frame_.markers.clear();
  frame_.forces.clear();
  frame_.truth.clear();
  started_ = true;
  open_ = true;
  part_count_ = 0;
  parts_.reset();
  markers_seen_ = 0;
  objects_seen_ = 0;
}

void FrameAssembler::count_gap(std::uint32_t frame_number) {
  const std::uint32_t missing = frame_number - frame_.frame_number - 1;
  if (missing > config_.reorder_window) {
    tally(AssemblerEvent::forward_jumps);
  } else {
    tally(AssemblerEvent::frames_missing, missing);
  }
}

void FrameAssembler::join(const TrackerDatagram& datagram) {
  tally(AssemblerEvent::datagrams_joined);
  if (datagram.stamp) {
    frame_.stamp_ns = datagram.stamp->stamp_ns;
    part_count_ = datagram.stamp->part_count;
    parts_.set(datagram.stamp->part);
  }
  for (const TrackedObject& object : datagram.objects) join_object(object);
  for (const TrackedMarker& marker : datagram.markers) join_marker(marker);
  for (const PadForce& force : datagram.forces) join_item(frame_.forces, force);
  for (const TargetTruth& truth : datagram.truth) join_item(frame_.truth, truth);
}

void FrameAssembler::join_object(const TrackedObject& object) {
  if (contains(config_.markers, object.name)) {
    join_marker({object.name, object.position, false});
    return;
  }
  if (join_item(frame_.objects, object) && contains(config_.objects, object.name)) ++objects_seen_;
}

void FrameAssembler::join_marker(const TrackedMarker& marker) {
  if (join_item(frame_.markers, marker) && contains(config_.markers, marker.name)) ++markers_seen_;
}

// The newest of the frames that are late is the one that says most.
void FrameAssembler::keep_late(const TrackerDatagram& datagram) {
  const std::uint32_t ahead = datagram.frame_number - late_.frame_number;
  if (!late_.markers.empty() && ahead >= kHalfRange) return;
  if (ahead != 0 || late_.markers.empty()) {
    late_.frame_number = datagram.frame_number;
    late_.stamp_ns.reset();
    late_.markers.clear();
  }
  if (datagram.stamp) late_.stamp_ns = datagram.stamp->stamp_ns;
  for (const TrackedMarker& marker : datagram.markers) join_item(late_.markers, marker);
  for (const TrackedObject& object : datagram.objects)
    if (contains(config_.markers, object.name))
      join_item(late_.markers, TrackedMarker{object.name, object.position, false});
}

template <typename List, typename Item>
bool FrameAssembler::join_item(List& list, const Item& item) {
  if (has_name(list, item.name)) {
    tally(AssemblerEvent::duplicate_items);
    return false;
  }
  if (list.push_back(item)) return true;
  tally(AssemblerEvent::overflowing_items);
  return false;
}

std::optional<FrameCompletion> FrameAssembler::completion() const {
  if (objects_seen_ < config_.objects.size()) return std::nullopt;
  if (part_count_ > 0) {
    if (parts_.count() < part_count_) return std::nullopt;
    return FrameCompletion::all_parts;
  }
  const bool names_expected = !config_.markers.empty() || !config_.objects.empty();
  if (!names_expected || markers_seen_ < config_.markers.size()) return std::nullopt;
  return FrameCompletion::all_names;
}

void FrameAssembler::close(FrameCompletion completion) {
  frame_.completion = completion;
  frame_.late = late_;
  late_.markers.clear();
  tally(event_of(completion));
  ready_[ready_count_++] = frame_;
  open_ = false;
}

}  // namespace tissued::protocol
