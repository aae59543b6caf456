#include "daemon/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>

#include <cerrno>

namespace tissued::daemon {

std::error_code schedule_realtime(pthread_t thread, int priority) noexcept {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return {::pthread_setschedparam(thread, SCHED_RR, &parameters), std::generic_category()};
}

std::error_code lock_memory() noexcept { return {::mlockall(MCL_CURRENT) == 0 ? 0 : errno, std::generic_category()}; }

}  // namespace tissued::daemon
