#pragma once

#include <pthread.h>

#include <system_error>

namespace tissued::daemon {

/// Below the kernel's own threads, above everything that is not in a hurry. The thread that serves sockets goes first:
/// it runs for microseconds, and without it nobody hears of a step.
inline constexpr int kSimulationPriority = 10;
inline constexpr int kServingPriority = 11;

/// Puts a thread, and those that it will start, under SCHED_RR, so that other work on the machine cannot hold up a
/// frame. Needs CAP_SYS_NICE or a limit (ulimit -r); says what the kernel said where it was refused.
std::error_code schedule_realtime(pthread_t thread, int priority) noexcept;

/// Keeps the memory that the process has now from being paged out. Needs CAP_IPC_LOCK or a limit (ulimit -l).
std::error_code lock_memory() noexcept;

}  // namespace tissued::daemon
