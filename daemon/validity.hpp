#pragma once

#include <cstdint>

#include "config/daemon_config.hpp"
#include "daemon/answer.hpp"
#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {

/// How far an answer may be trusted at one moment.
struct Verdict {
  protocol::Validity validity = protocol::Validity::no_data;
  std::uint16_t reasons = 0;  ///< protocol::ValidityReason bits
  std::uint64_t age_ns = 0;   ///< of the tracker frame behind the answer, its delay included; 0 without one
};

/// Judges `answer` at `now_ns` (monotonic clock): what its step said, and what its age makes of it. Older than
/// stale_after it is degraded, older than lost_after invalid; a step thrown away or a missing registration makes it
/// invalid at any age.
Verdict judge(const Answer& answer, std::uint64_t now_ns, const config::StalenessConfig& staleness);

}  // namespace tissued::daemon
