#include "daemon/pacing.hpp"

#include <ctime>

namespace tissued::daemon {

void sleep_until_ns(std::uint64_t deadline_ns) noexcept {
  constexpr std::uint64_t kSecond = 1'000'000'000;
  const timespec deadline{static_cast<time_t>(deadline_ns / kSecond), static_cast<long>(deadline_ns % kSecond)};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
}

}  // namespace tissued::daemon
