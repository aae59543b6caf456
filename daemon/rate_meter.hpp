#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tissued::daemon {

/// How often something happened in the last second. For one thread; nothing allocates.
class RateMeter {
 public:
  static constexpr std::size_t kMaxRate_hz = 2048;  ///< higher rates read as this

  /// time_ns: not before that of the last event.
  void note(std::uint64_t time_ns) noexcept {
    times_[count_ % kMaxRate_hz] = time_ns;
    ++count_;
  }

  double rate_hz(std::uint64_t now_ns) const noexcept {
    constexpr std::uint64_t kSecond_ns = 1'000'000'000;
    std::size_t recent = 0;
    const std::size_t kept = count_ < kMaxRate_hz ? count_ : kMaxRate_hz;
    while (recent < kept && times_[(count_ - 1 - recent) % kMaxRate_hz] + kSecond_ns > now_ns) ++recent;
    return static_cast<double>(recent);
  }

 private:
  std::array<std::uint64_t, kMaxRate_hz> times_{};
  std::size_t count_ = 0;
};

}  // namespace tissued::daemon
