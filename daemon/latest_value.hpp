#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <utility>

namespace tissued::daemon {

/// Hands the newest value from one writer thread to one reader thread; older unread values are overwritten.
///
/// A triple buffer: the writer fills its own slot, the reader reads its own, and a third changes hands by one atomic
/// exchange, so neither side ever waits, retries or allocates. All three values are built from the same constructor
/// arguments: give vectors their full size there and never resize them after.
template <typename T>
class LatestValue {
 public:
  template <typename... Args>
  explicit LatestValue(const Args&... args) : slots_{Slot{T(args...)}, Slot{T(args...)}, Slot{T(args...)}} {}

  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer: the value under construction. It holds what was written some publications ago: write every field.
  T& back() { return slots_[back_].value; }

  /// Writer: makes back() the newest value and gives out another slot as back(). Returns true when the value
  /// published before was never read: it is lost now.
  bool publish() {
    const std::uint32_t previous = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel);
    back_ = previous & kIndex;
    return (previous & kFresh) != 0;
  }

  /// Reader: makes the newest value front(). Returns false, and leaves front() alone, when there is nothing newer.
  bool fetch() {
    if (!fresh()) return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Reader: would fetch() find something newer?
  bool fresh() const { return (middle_.load(std::memory_order_acquire) & kFresh) != 0; }

  /// Reader: the value fetched last; as constructed before the first fetch.
  const T& front() const { return slots_[front_].value; }

 private:
  static constexpr std::uint32_t kIndex = 3;
  static constexpr std::uint32_t kFresh = 4;
  static constexpr std::size_t kCacheLine = 64;  // neighbours on one line would slow each other down
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

  struct alignas(kCacheLine) Slot {
    T value;
  };

  std::array<Slot, 3> slots_;
  alignas(kCacheLine) std::uint32_t back_ = 0;                // writer's own
  alignas(kCacheLine) std::uint32_t front_ = 1;               // reader's own
  alignas(kCacheLine) std::atomic<std::uint32_t> middle_{2};  // slot in between, and whether the writer put it there
};

}  // namespace tissued::daemon
