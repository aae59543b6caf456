#include "daemon/step_watch.hpp"

#include <algorithm>
#include <chrono>

#include "daemon/monotonic_clock.hpp"
#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kShortestWait_ns = 1'000'000;
constexpr std::uint64_t kTimesDone = 4;
constexpr std::uint64_t kMost_ns = 5'000'000'000;

}  // namespace

void StepWatch::on_submitted() {
  if (least_ns_ > 0 && !watching_) look_in(longest_ns_);
}

void StepWatch::on_answered(const Answer& answer) {
  const bool braked = (answer.reasons & protocol::ValidityReason::kStepBraked) != 0;
  longest_ns_ = braked ? std::min(2 * longest_ns_, std::max(kMost_ns, least_ns_))
                       : std::max(least_ns_, kTimesDone * answer.step_time_ns);
}

void StepWatch::look_in(std::uint64_t wait_ns) {
  watching_ = true;
  timer_.expires_after(std::chrono::nanoseconds(wait_ns));
  timer_.async_wait(remembered(memory_, [this](const boost::system::error_code& error) {
    watching_ = false;
    if (!error) look();
  }));
}

void StepWatch::look() {
  const std::uint64_t now_ns = monotonic_ns();
  const std::uint64_t began_ns = simulation_.brake_step(now_ns - std::min(now_ns, longest_ns_));
  if (began_ns == 0) return;
  const std::uint64_t due_ns = began_ns + longest_ns_;
  look_in(std::max(due_ns > now_ns ? due_ns - now_ns : longest_ns_, kShortestWait_ns));
}

}  // namespace tissued::daemon
