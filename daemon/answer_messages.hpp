#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "daemon/answer.hpp"
#include "daemon/counters.hpp"
#include "daemon/validity.hpp"
#include "protocol/mesh_messages.hpp"
#include "protocol/prediction_messages.hpp"
#include "protocol/probe_messages.hpp"
#include "protocol/session_file.hpp"
#include "protocol/status_messages.hpp"

namespace tissued::daemon {

protocol::AlarmState alarm_state(const AlarmAnswer& alarm);

/// The answer as it is recorded, made of the tracker frame `stepped_frame`.
protocol::AnswerSummary answer_summary(std::uint32_t stepped_frame, const Answer& answer);

/// How many Predictions an answer needs; at least one.
std::size_t prediction_part_count(const Answer& answer);

/// Part `part` of the answer as it is sent at send_ns (monotonic clock).
protocol::Predictions prediction_part(const Answer& answer, const Verdict& verdict, std::uint64_t send_ns,
                                      std::size_t part);

/// How many ProbeViews one probe needs; at least one.
std::size_t probe_view_part_count(const Answer& answer, std::size_t probe);

/// Part `part` of what the answer says about one probe. image: its calibration, where it is known.
protocol::ProbeView probe_view_part(const Answer& answer, const std::optional<core::ImagePlane>& image,
                                    const Verdict& verdict, std::uint64_t send_ns, std::size_t probe, std::size_t part);

/// How many Status messages all counters need.
constexpr std::size_t status_part_count() {
  return protocol::chunk_count(Counters::kSize, protocol::Status::kCountersPerPart);
}

/// Fills in part, part_count and that part's counters.
void fill_status_counters(protocol::Status& status, const Counters& counters, std::size_t part);

}  // namespace tissued::daemon
