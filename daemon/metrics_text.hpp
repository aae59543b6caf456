#pragma once

#include <string>

#include "daemon/answer.hpp"
#include "daemon/counters.hpp"
#include "daemon/duration_histogram.hpp"
#include "protocol/status_messages.hpp"

namespace tissued::daemon {

/// What there is to say about a running daemon; refers to what it says it of.
struct Metrics {
  const protocol::Status& status;  ///< its counters are not asked for
  const Answer& answer;            ///< the newest
  const Counters& counters;
  const DurationHistogram& latency;  ///< from receiving a frame to sending its predictions
  const DurationHistogram& step;
};

/// In Prometheus' text format, version 0.0.4; base units, but for mm, which the names say.
std::string metrics_text(const Metrics& metrics);

}  // namespace tissued::daemon
