#include "daemon/answer_messages.hpp"

#include <algorithm>

namespace tissued::daemon {

using protocol::Predictions;
using protocol::ProbeView;
using protocol::Status;

protocol::AlarmState alarm_state(const AlarmAnswer& alarm) {
  return {alarm.watching, alarm.raised, alarm.has_place, alarm.since_frame,
          alarm.since_ns, alarm.level,  alarm.misfit,    alarm.place};
}

protocol::AnswerSummary answer_summary(std::uint32_t stepped_frame, const Answer& answer) {
  protocol::AnswerSummary summary;
  summary.stepped_frame = stepped_frame;
  summary.tracker_frame = answer.tracker_frame;
  summary.reasons = answer.reasons;
  summary.iterations = static_cast<std::uint16_t>(answer.report.iterations);
  summary.markers_used = static_cast<std::uint16_t>(answer.report.markers_used);
  summary.markers_seen = answer.markers_seen;
  summary.step_time_ns = answer.step_time_ns;
  summary.innovation_rms = answer.report.innovation_rms;
  summary.alarm = alarm_state(answer.alarm);
  for (const TargetPlace& target : answer.targets) summary.targets.push_back(target.position);
  return summary;
}

std::size_t prediction_part_count(const Answer& answer) {
  return std::max(protocol::chunk_count(answer.targets.size(), Predictions::kTargetsPerPart),
                  protocol::chunk_count(answer.pads.size(), Predictions::kPadsPerPart));
}

Predictions prediction_part(const Answer& answer, const Verdict& verdict, std::uint64_t send_ns, std::size_t part) {
  Predictions message;
  message.part = static_cast<std::uint8_t>(part);
  message.part_count = static_cast<std::uint8_t>(prediction_part_count(answer));
  message.validity = verdict.validity;
  message.reasons = verdict.reasons;
  message.tracker_frame = answer.tracker_frame;
  message.has_stamp = answer.stamp_ns.has_value();
  message.stamp_ns = answer.stamp_ns.value_or(0);
  message.receive_ns = answer.receive_ns;
  message.send_ns = send_ns;
  message.age_ns = verdict.age_ns;
  message.step_time_ns = answer.step_time_ns;
  message.primal_residual = answer.report.primal_residual;
  message.dual_residual = answer.report.dual_residual;
  message.innovation_rms = answer.report.innovation_rms;
  message.alarm = alarm_state(answer.alarm);
  message.iterations = static_cast<std::uint16_t>(answer.report.iterations);
  message.markers_used = static_cast<std::uint16_t>(answer.report.markers_used);
  message.markers_seen = answer.markers_seen;
  const std::size_t first_target = part * Predictions::kTargetsPerPart;
  const std::size_t target_end = std::min(first_target + Predictions::kTargetsPerPart, answer.targets.size());
  for (std::size_t i = first_target; i < target_end; ++i) {
    const TargetPlace& target = answer.targets[i];
    message.targets.push_back({static_cast<std::uint16_t>(i), target.position, target.covariance,
                               target.truth.has_value(), target.truth.value_or(std::array<double, 3>{})});
  }
  const std::size_t first_pad = part * Predictions::kPadsPerPart;
  const std::size_t pad_end = std::min(first_pad + Predictions::kPadsPerPart, answer.pads.size());
  for (std::size_t i = first_pad; i < pad_end; ++i) {
    message.pads.push_back({answer.pads[i].index, answer.pads[i].force});
  }
  return message;
}

std::size_t probe_view_part_count(const Answer& answer, std::size_t probe) {
  return protocol::chunk_count(answer.probes[probe].targets.size(), ProbeView::kTargetsPerPart);
}

ProbeView probe_view_part(const Answer& answer, const std::optional<core::ImagePlane>& image, const Verdict& verdict,
                          std::uint64_t send_ns, std::size_t probe, std::size_t part) {
  const ProbeAnswer& seen = answer.probes[probe];
  ProbeView message;
  message.part = static_cast<std::uint8_t>(part);
  message.part_count = static_cast<std::uint8_t>(probe_view_part_count(answer, probe));
  message.validity = verdict.validity;
  message.reasons = verdict.reasons;
  message.seen = seen.seen;
  message.has_image = image.has_value();
  message.index = static_cast<std::uint16_t>(probe);
  message.probe_count = static_cast<std::uint16_t>(answer.probes.size());
  message.tracker_frame = answer.tracker_frame;
  message.receive_ns = answer.receive_ns;
  message.send_ns = send_ns;
  message.age_ns = verdict.age_ns;
  message.force = seen.force;
  if (image) {
    message.size = {static_cast<std::uint16_t>(image->size.x()), static_cast<std::uint16_t>(image->size.y())};
    message.spacing = {image->spacing.x(), image->spacing.y()};
  }
  const std::size_t first = part * ProbeView::kTargetsPerPart;
  const std::size_t end = std::min(first + ProbeView::kTargetsPerPart, seen.targets.size());
  for (std::size_t i = first; i < end; ++i) {
    const core::ImagePoint& point = seen.targets[i];
    const core::Ellipse ellipse = core::ellipse_of(point.covariance);
    message.targets.push_back({static_cast<std::uint16_t>(i),
                               point.inside,
                               {point.pixel.x(), point.pixel.y()},
                               point.distance,
                               point.distance_sd,
                               {ellipse.major, ellipse.minor},
                               ellipse.angle});
  }
  return message;
}

void fill_status_counters(Status& status, const Counters& counters, std::size_t part) {
  status.part = static_cast<std::uint8_t>(part);
  status.part_count = static_cast<std::uint8_t>(status_part_count());
  status.counters.clear();
  const std::size_t first = part * Status::kCountersPerPart;
  const std::size_t end = std::min(first + Status::kCountersPerPart, Counters::kSize);
  for (std::size_t i = first; i < end; ++i) {
    status.counters.push_back({static_cast<std::uint16_t>(i), counters.value(i)});
  }
}

}  // namespace tissued::daemon
