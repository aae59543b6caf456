#include "daemon/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace tissued::daemon {
namespace {

// `0-3`, as the kernel writes it.
std::string allowed_cpus() {
  const std::string key = "Cpus_allowed_list:";
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key)) return line.substr(line.find_first_not_of(" \t", key.size()));
  }
  return "others";
}

std::string limit_on(decltype(RLIMIT_RTPRIO) resource) {
  rlimit limit{};
  ::getrlimit(resource, &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "infinity" : std::to_string(limit.rlim_cur);
}

}  // namespace

std::optional<std::string> schedule_realtime(const char* what, pthread_t thread, int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = ::pthread_setschedparam(thread, SCHED_RR, &parameters);
  if (error == 0) return std::nullopt;
  return std::string("no real-time scheduling of ") + what + ": " + std::strerror(error) + "; raise the limit " +
         limit_on(RLIMIT_RTPRIO) + " to " + std::to_string(priority) +
         " (ulimit -r, LimitRTPRIO= of a unit) or grant CAP_SYS_NICE";
}

std::optional<std::string> pin_to_cpu(const char* what, pthread_t thread, int cpu) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  const int error = ::pthread_setaffinity_np(thread, sizeof cpus, &cpus);
  if (error == 0) return std::nullopt;
  return std::string(what) + " not pinned to CPU " + std::to_string(cpu) + ": " + std::strerror(error) +
         "; this process may use " + allowed_cpus() + " (taskset, CPUAffinity= or AllowedCPUs= of a unit)";
}

void leave_realtime() noexcept {
  const sched_param none{};
  ::pthread_setschedparam(::pthread_self(), SCHED_OTHER, &none);
  cpu_set_t cpus;
  std::memset(&cpus, 0xFF, sizeof cpus);  // those that the process may not use are left out by the kernel
  ::pthread_setaffinity_np(::pthread_self(), sizeof cpus, &cpus);
}

std::optional<std::string> lock_memory() {
  if (::mlockall(MCL_CURRENT) == 0) return std::nullopt;
  return std::string("memory may be paged out: ") + std::strerror(errno) + "; raise the limit " +
         limit_on(RLIMIT_MEMLOCK) + " bytes to infinity (ulimit -l, LimitMEMLOCK= of a unit) or grant CAP_IPC_LOCK";
}

}  // namespace tissued::daemon
