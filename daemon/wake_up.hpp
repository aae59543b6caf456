#pragma once

#include <atomic>
#include <cstdint>

namespace tissued::daemon {

/// Lets one thread sleep until another has something for it. Notifications are not counted: the sleeper looks at
/// everything it may have work from, then waits for the ticket it drew before it looked.
///
///     for (;;) {
///       const auto ticket = wake_up.ticket();
///       if (!work_found()) wake_up.wait(ticket);
///     }
class WakeUp {
 public:
  std::uint32_t ticket() const { return generation_.load(std::memory_order_acquire); }

  /// Returns at once if notify() was called since the ticket was drawn.
  void wait(std::uint32_t ticket) const { generation_.wait(ticket, std::memory_order_acquire); }

  /// Wait-free for the caller but for the system call that wakes a sleeper.
  void notify() {
    generation_.fetch_add(1, std::memory_order_release);
    generation_.notify_one();
  }

 private:
  std::atomic<std::uint32_t> generation_{0};
};

}  // namespace tissued::daemon
