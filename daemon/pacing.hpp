#pragma once

#include <cstdint>

namespace tissued::daemon {

/// Sleeps until the monotonic clock reads `deadline_ns`; one in the past is no sleep. Deadlines are absolute, so that a
/// late frame does not push all frames after it. A signal ends the sleep early.
void sleep_until_ns(std::uint64_t deadline_ns) noexcept;

}  // namespace tissued::daemon
