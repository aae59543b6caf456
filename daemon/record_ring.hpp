#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tissued::daemon {

/// Hands records of bytes from one thread to another, in order. Neither side ever waits; what finds no room is not
/// taken. Allocates at construction only.
class RecordRing {
 public:
  struct Entry {
    std::uint8_t kind = 0;
    std::uint64_t stamp_ns = 0;
    std::size_t size = 0;  ///< bytes of the body
  };

  /// capacity: bytes; each record takes 16 beside its body.
  explicit RecordRing(std::size_t capacity) : bytes_(capacity) {}

  /// Writer. False where there is no room.
  bool push(std::uint8_t kind, std::uint64_t stamp_ns, std::span<const std::uint8_t> body) noexcept {
    const std::uint64_t begin = written_.load(std::memory_order_relaxed);
    const std::uint64_t used = begin - read_.load(std::memory_order_acquire);
    if (used + kHead + body.size() > bytes_.size()) return false;
    std::uint8_t head[kHead]{};
    const auto size = static_cast<std::uint32_t>(body.size());
    std::memcpy(head, &stamp_ns, sizeof stamp_ns);
    std::memcpy(head + 8, &size, sizeof size);
    head[12] = kind;
    copy_in(begin, head);
    copy_in(begin + kHead, body);
    written_.store(begin + kHead + body.size(), std::memory_order_release);
    return true;
  }

  /// Reader. Copies the oldest record's body into `body`, which holds the largest there is; false where there is none.
  bool pop(Entry& entry, std::span<std::uint8_t> body) noexcept {
    const std::uint64_t begin = read_.load(std::memory_order_relaxed);
    if (begin == written_.load(std::memory_order_acquire)) return false;
    std::uint8_t head[kHead];
    copy_out(begin, head);
    std::uint32_t size = 0;
    std::memcpy(&entry.stamp_ns, head, sizeof entry.stamp_ns);
    std::memcpy(&size, head + 8, sizeof size);
    entry.kind = head[12];
    entry.size = std::min<std::size_t>(size, body.size());
    copy_out(begin + kHead, body.first(entry.size));
    read_.store(begin + kHead + size, std::memory_order_release);
    return true;
  }

 private:
  static constexpr std::size_t kHead = 16, kCacheLine = 64;

  void copy_in(std::uint64_t at, std::span<const std::uint8_t> from) noexcept {
    const std::size_t place = at % bytes_.size(), first = std::min(from.size(), bytes_.size() - place);
    std::copy_n(from.begin(), first, bytes_.begin() + static_cast<std::ptrdiff_t>(place));
    std::copy(from.begin() + static_cast<std::ptrdiff_t>(first), from.end(), bytes_.begin());
  }
  void copy_out(std::uint64_t at, std::span<std::uint8_t> to) const noexcept {
    const std::size_t place = at % bytes_.size(), first = std::min(to.size(), bytes_.size() - place);
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(place), first, to.begin());
    std::copy_n(bytes_.begin(), to.size() - first, to.begin() + static_cast<std::ptrdiff_t>(first));
  }

  std::vector<std::uint8_t> bytes_;
  alignas(kCacheLine) std::atomic<std::uint64_t> written_{0};  // bytes, ever
  alignas(kCacheLine) std::atomic<std::uint64_t> read_{0};
};

}  // namespace tissued::daemon
