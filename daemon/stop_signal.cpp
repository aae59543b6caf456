#include "daemon/stop_signal.hpp"

#include <atomic>
#include <csignal>

namespace tissued::daemon {
namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // or a signal handler could not touch it

extern "C" void remember_stop(int) { stop_requested.store(true, std::memory_order_relaxed); }

}  // namespace

StopSignal::StopSignal() {
  stop_requested.store(false, std::memory_order_relaxed);
  struct sigaction action {};
  action.sa_handler = remember_stop;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // and no SA_RESTART: a wait is to end
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

StopSignal::~StopSignal() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool StopSignal::requested() const noexcept { return stop_requested.load(std::memory_order_relaxed); }

}  // namespace tissued::daemon
