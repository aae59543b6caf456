#include "daemon/frame_joiner.hpp"

#include "daemon/name_table.hpp"

namespace tissued::daemon {
namespace {

// The markers that the bundle knows, and the deadline.
protocol::FrameAssemblerConfig assembler_config(const config::DaemonConfig& config) {
  protocol::FrameAssemblerConfig result;
  result.deadline_ns = static_cast<std::uint64_t>(config.tracker.frame_deadline.count());
  for (const auto& marker : config.bundle.scene.markers) result.markers.push_back(wire_name(marker.name));
  for (const auto& name : config.unused_markers) result.markers.push_back(wire_name(name));
  return result;
}

}  // namespace

FrameJoiner::FrameJoiner(const config::DaemonConfig& config)
    : assembler_(assembler_config(config)),
      subject_prefix_(config.tracker.subject.empty() ? "" : config.tracker.subject + ":") {}

std::span<const protocol::TrackerFrame> FrameJoiner::add(std::span<const std::uint8_t> bytes,
                                                         std::uint64_t receive_ns) {
  refusal_ = protocol::decode_tracker_datagram(bytes, datagram_);
  if (refusal_ != protocol::TrackerRefusal::none) return {};
  if (!subject_prefix_.empty()) {
    for (auto& object : datagram_.objects) strip_subject(object.name);
    for (auto& marker : datagram_.markers) strip_subject(marker.name);
    for (auto& force : datagram_.forces) strip_subject(force.name);
    for (auto& truth : datagram_.truth) strip_subject(truth.name);
  }
  return assembler_.add(datagram_, receive_ns);
}

int FrameJoiner::skipped_items() const {
  return refusal_ == protocol::TrackerRefusal::none ? static_cast<int>(datagram_.skipped_items) : 0;
}

void FrameJoiner::strip_subject(protocol::Name& name) const {
  const auto text = name.view();
  if (!text.starts_with(subject_prefix_)) return;
  if (const auto bare = protocol::Name::from(text.substr(subject_prefix_.size()))) name = *bare;
}

}  // namespace tissued::daemon
