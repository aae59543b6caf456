#include "daemon/frame_clock.hpp"

#include <algorithm>

namespace tissued::daemon {

namespace {

constexpr double kLongestGap = 60.0;   // s; a clock that advances by more has jumped
constexpr double kShortestStep = 0.1;  // of the period; datagrams that came in a burst must not give a step of no time
constexpr std::uint64_t kForgotten = 1000;  // of the time, one part: clocks that are disciplined drift by less
constexpr double kBand[] = {0.75, 1.33};    // of the period
constexpr double kOutsideForChange = 1.0;   // s

double seconds(std::uint64_t ns) { return static_cast<double>(ns) * 1e-9; }

// s, between two readings of one clock; absent where it stood still, ran backwards or jumped.
std::optional<double> advanced(std::uint64_t from_ns, std::uint64_t to_ns) {
  if (to_ns <= from_ns) return std::nullopt;
  const double elapsed = seconds(to_ns - from_ns);
  return elapsed <= kLongestGap ? std::optional(elapsed) : std::nullopt;
}

}  // namespace

FrameInterval FrameClock::advance(const protocol::TrackerFrame& frame) {
  FrameInterval interval;
  if (!started_ || frame.after_restart) {
    interval.elapsed = period_;
    samples_ = 0;
    outside_ = 0.0;
  } else {
    interval.elapsed = elapsed_since_last(frame, interval);
    watch_rate(frame);
  }
  interval.delay = delay_of(frame, !started_ || frame.after_restart || interval.stamp_refused);
  interval.dt = std::clamp(interval.elapsed, std::min(kShortestStep * period_, kMaxTimeStep), kMaxTimeStep);
  interval.clamped = interval.dt != interval.elapsed;
  started_ = true;
  last_number_ = frame.frame_number;
  last_receive_ns_ = frame.receive_ns;
  last_stamp_ns_ = frame.stamp_ns;
  return interval;
}

double FrameClock::elapsed_since_last(const protocol::TrackerFrame& frame, FrameInterval& interval) const {
  if (frame.stamp_ns && last_stamp_ns_) {
    if (const auto elapsed = advanced(*last_stamp_ns_, *frame.stamp_ns)) return *elapsed;
    interval.stamp_refused = true;
  }
  const std::uint32_t numbers = frame.frame_number - last_number_;  // modulo 2^32
  const double elapsed = numbers * number_period_;
  if (numbers > 0 && elapsed <= kLongestGap) return elapsed;
  return advanced(last_receive_ns_, frame.receive_ns).value_or(period_);
}

// anew: what the stamps were before says nothing of this one.
double FrameClock::delay_of(const protocol::TrackerFrame& frame, bool anew) {
  if (anew || !frame.stamp_ns) quickest_ns_.reset();
  if (!frame.stamp_ns) return 0.0;
  const auto under_way_ns = static_cast<std::int64_t>(frame.receive_ns - *frame.stamp_ns);  // modulo 2^64
  if (quickest_ns_ && frame.receive_ns > last_receive_ns_)
    *quickest_ns_ += static_cast<std::int64_t>((frame.receive_ns - last_receive_ns_) / kForgotten);
  if (!quickest_ns_ || under_way_ns < *quickest_ns_) quickest_ns_ = under_way_ns;
  return static_cast<double>(under_way_ns - *quickest_ns_) * 1e-9;
}

// Receive times jitter, so the median decides; without stamps they are all there is, for frame numbers know no rate.
void FrameClock::watch_rate(const protocol::TrackerFrame& frame) {
  const bool stamped = frame.stamp_ns && last_stamp_ns_;
  const auto elapsed =
      stamped ? advanced(*last_stamp_ns_, *frame.stamp_ns) : advanced(last_receive_ns_, frame.receive_ns);
  const std::uint32_t numbers = frame.frame_number - last_number_;
  if (!elapsed || numbers == 0) return;
  intervals_.values[samples_ % kWindow] = *elapsed;
  number_intervals_.values[samples_ % kWindow] = *elapsed / numbers;
  ++samples_;
  if (samples_ < kWindow) return;
  const double ratio = intervals_.median(kWindow) / period_;
  outside_ = ratio < kBand[0] || ratio > kBand[1] ? outside_ + *elapsed : 0.0;
}

std::optional<double> FrameClock::changed_period() const {
  if (samples_ < kWindow || outside_ < kOutsideForChange) return std::nullopt;
  const double period = std::clamp(intervals_.median(kWindow), 1e-4, kMaxTimeStep);
  // At the limit of what we follow the median stays outside for good; there is nothing to change then.
  return period != period_ ? std::optional(period) : std::nullopt;
}

void FrameClock::adopt_period() {
  if (const auto period = changed_period()) period_ = *period;
  number_period_ = number_intervals_.median(kWindow);
  outside_ = 0.0;
}

double FrameClock::Ring::median(std::size_t size) const {
  auto sorted = values;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(size / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(size));
  return *middle;
}

}  // namespace tissued::daemon
