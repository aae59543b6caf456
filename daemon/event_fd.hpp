#pragma once

namespace tissued::daemon {

/// A Linux eventfd: any thread, without blocking or allocating, makes a descriptor readable that another one polls.
class EventFd {
 public:
  /// Throws std::system_error where the process has no descriptor left.
  EventFd();
  ~EventFd();
  EventFd(const EventFd&) = delete;
  EventFd& operator=(const EventFd&) = delete;

  void notify() noexcept;
  /// Makes the descriptor unreadable again, however often it was notified.
  void drain() noexcept;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace tissued::daemon
