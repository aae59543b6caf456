#include "daemon/validity.hpp"

namespace tissued::daemon {

using protocol::Validity;
using protocol::ValidityReason;

Verdict judge(const Answer& answer, std::uint64_t now_ns, const config::StalenessConfig& staleness) {
  Verdict verdict{Validity::no_data, answer.reasons, 0};
  if (!answer.has_frame) return verdict;
  verdict.age_ns = (now_ns > answer.receive_ns ? now_ns - answer.receive_ns : 0) + answer.delay_ns;
  if (verdict.age_ns > static_cast<std::uint64_t>(staleness.stale_after.count())) {
    verdict.reasons |= ValidityReason::kTrackerSilent;
  }
  const bool lost = verdict.age_ns > static_cast<std::uint64_t>(staleness.lost_after.count());
  if (lost || (verdict.reasons & (ValidityReason::kDiverged | ValidityReason::kNotRegistered)) != 0) {
    verdict.validity = Validity::invalid;
  } else {
    verdict.validity = verdict.reasons == 0 ? Validity::valid : Validity::degraded;
  }
  return verdict;
}

}  // namespace tissued::daemon
