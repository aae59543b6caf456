#pragma once

#include <cstdint>

#include "protocol/client_header.hpp"
#include "protocol/fixed_list.hpp"
#include "protocol/prediction_messages.hpp"

// How the daemon is doing.

namespace tissued::protocol {

// Answered by Status, all its parts.
struct QueryStatus {
  static constexpr MessageType kType = MessageType::query_status;
};

struct Counter {
  std::uint16_t index = 0;  // in the names table of kind counter
  std::uint64_t value = 0;  // since the daemon started
};

// Latencies run from the first datagram of a tracker frame to the sending of its predictions, over the daemon's recent
// frames. More than kCountersPerPart counters go out in parts with equal scalars.
struct Status {
  static constexpr MessageType kType = MessageType::status;
  std::uint8_t part = 0;
  std::uint8_t part_count = 1;
  Validity validity = Validity::no_data;  // of the newest answer
  std::uint16_t reasons = 0;              // ValidityReason bits of the newest answer
  std::uint16_t subscribers = 0;
  std::uint64_t uptime_ns = 0;
  std::uint64_t send_ns = 0;  // daemon's clock
  std::uint64_t latency_p50_ns = 0;
  std::uint64_t latency_p99_ns = 0;
  std::uint64_t latency_max_ns = 0;
  std::uint64_t step_p50_ns = 0;
  std::uint64_t step_p99_ns = 0;
  std::uint64_t step_max_ns = 0;
  double tracker_rate_hz = 0;  // frames received per second, recently
  double step_rate_hz = 0;     // frames simulated per second, recently
  AlarmState alarm;            // of the newest answer

  static constexpr std::size_t kCountersPerPart = 100;
  FixedList<Counter, kCountersPerPart> counters;
};

ClientRefusal read_body(ByteReader& reader, QueryStatus& message);
ClientRefusal read_body(ByteReader& reader, Status& message);
void write_body(ByteWriter& writer, const QueryStatus& message);
void write_body(ByteWriter& writer, const Status& message);

}  // namespace tissued::protocol
