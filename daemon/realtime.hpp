#pragma once

#include <pthread.h>

#include <optional>
#include <string>

namespace tissued::daemon {

/// Below the kernel's own threads, above everything that is not in a hurry. The thread that serves sockets goes first:
/// it runs for microseconds, and without it nobody hears of a step.
inline constexpr int kSimulationPriority = 10;
inline constexpr int kServingPriority = 11;

// What the kernel refuses comes back as one line, with the limit to raise; nothing where it was granted. `what` names
// the thread in that line.

/// Puts a thread, and those that it will start, under SCHED_RR, so that other work on the machine cannot hold up a
/// frame. Not SCHED_FIFO: threads of one step share a priority, and none may keep the CPU from the one that it waits
/// for. Needs CAP_SYS_NICE or a limit.
std::optional<std::string> schedule_realtime(const char* what, pthread_t thread, int priority);

/// Keeps a thread, and those that it will start, on one CPU, counted from 0.
std::optional<std::string> pin_to_cpu(const char* what, pthread_t thread, int cpu);

/// The calling thread, started by one that is in real time or pinned, has no hurry: any CPU, when it is free.
void leave_realtime() noexcept;

/// Keeps the memory that the process has now from being paged out. Needs CAP_IPC_LOCK or a limit.
std::optional<std::string> lock_memory();

}  // namespace tissued::daemon
