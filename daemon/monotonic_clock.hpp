#pragma once

#include <cstdint>

namespace tissued::daemon {

/// CLOCK_MONOTONIC in ns: the clock of all receive and send stamps. Never steps; shared by all processes of a machine.
std::uint64_t monotonic_ns() noexcept;

}  // namespace tissued::daemon
