#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

/// How long after the frame before it a frame was.
struct FrameInterval {
  double elapsed = 0.0;        ///< s, as measured
  double dt = 0.0;             ///< s, what the step is told: elapsed within [0.1 period, kMaxTimeStep]
  bool clamped = false;        ///< dt is not elapsed
  bool stamp_refused = false;  ///< both frames had a stamp of the tracker's clock, and the difference made no sense
  double delay = 0.0;          ///< s by which it was longer under way than the quickest frame; 0 without stamps
};

/// Measures the time between the frames that are stepped (not between all that came), and notices when the tracker has
/// changed its rate.
///
/// Time comes from the tracker's stamps where both frames carry one and it advanced, by at most a minute; else from the
/// frame numbers times the frame period, by at most a minute again; else from the receive times. The first frame, and
/// the first one after the tracker restarted, count as one period.
///
/// Stamps also tell how much longer than the quickest frame one was under way, whatever the two clocks show: the
/// difference of receive time and stamp, less the least so far. Clocks drift apart, so the least is forgotten by a
/// thousandth of the time: a delay that grows more slowly than that, or has been there from the start, is not seen.
class FrameClock {
 public:
  static constexpr double kMaxTimeStep = 0.2;  // s; after a longer gap the motion in between is unknown anyway

  /// period: s, nominal, > 0.
  explicit FrameClock(double period) : period_(period), number_period_(period) {}

  FrameInterval advance(const protocol::TrackerFrame& frame);

  /// s; the median of the recent intervals, once it has been outside [0.75, 1.33] of the period for a second. The
  /// caller then tells adopt_period() or is told again.
  std::optional<double> changed_period() const;
  void adopt_period();
  /// Leaves the period as it is and watches for another second.
  void keep_period() { outside_ = 0.0; }
  double period() const { return period_; }

 private:
  static constexpr std::size_t kWindow = 15;  // frames

  struct Ring {
    std::array<double, kWindow> values{};
    double median(std::size_t size) const;
  };

  double elapsed_since_last(const protocol::TrackerFrame& frame, FrameInterval& interval) const;
  void watch_rate(const protocol::TrackerFrame& frame);
  double delay_of(const protocol::TrackerFrame& frame, bool anew);

  double period_;         // s, between steps
  double number_period_;  // s, between consecutive frame numbers: what a number is worth where there are no stamps
  bool started_ = false;
  std::uint32_t last_number_ = 0;
  std::uint64_t last_receive_ns_ = 0;
  std::optional<std::uint64_t> last_stamp_ns_;
  std::optional<std::int64_t> quickest_ns_;  // receive time less stamp
  Ring intervals_;                           // s, between steps
  Ring number_intervals_;                    // s, the same per frame number
  std::size_t samples_ = 0;
  double outside_ = 0.0;  // s for which the median has been outside of the band
};

}  // namespace tissued::daemon
