#include "daemon/frame_clock.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>

#include "tests/daemon/tracker_frames.hpp"

using tissued::daemon::FrameClock;
using tissued::daemon::FrameInterval;

namespace {

constexpr std::uint64_t kMs = 1'000'000;

}  // namespace

TEST_CASE("The first frame counts as one period") {
  FrameClock clock(0.01);
  const FrameInterval interval = clock.advance(FrameBuilder(77).stamp(123456789).frame);
  CHECK(interval.dt == 0.01);
  CHECK_FALSE(interval.clamped);
}

TEST_CASE("Stamps come before frame numbers, frame numbers before receive times") {
  FrameClock clock(0.01);
  clock.advance(FrameBuilder(1).stamp(0).received(0).frame);
  CHECK(clock.advance(FrameBuilder(2).stamp(12 * kMs).received(50 * kMs).frame).dt == Approx(0.012));
  // One of both without a stamp: three numbers of 10 ms.
  CHECK(clock.advance(FrameBuilder(5).received(60 * kMs).frame).dt == Approx(0.03));
  CHECK(clock.advance(FrameBuilder(6).stamp(90 * kMs).received(70 * kMs).frame).dt == Approx(0.01));
  // Numbers that went back, no stamp: receive times.
  CHECK(clock.advance(FrameBuilder(3).received(85 * kMs).frame).dt == Approx(0.015));
}

TEST_CASE("A stamp that stands still, runs back or jumps is refused, and frame numbers take over") {
  FrameClock clock(0.01);
  clock.advance(FrameBuilder(10).stamp(100 * kMs).frame);
  const auto stamp = GENERATE(std::uint64_t{100 * kMs}, std::uint64_t{99 * kMs}, std::uint64_t{0},
                              std::uint64_t{100 * kMs + 61'000 * kMs}, ~std::uint64_t{0});
  const FrameInterval interval = clock.advance(FrameBuilder(12).stamp(stamp).frame);
  CHECK(interval.stamp_refused);
  CHECK(interval.dt == Approx(0.02));
}

TEST_CASE("Frame numbers wrap around") {
  FrameClock clock(0.01);
  clock.advance(FrameBuilder(0xFFFFFFFFu).received(0).frame);
  CHECK(clock.advance(FrameBuilder(1).received(5 * kMs).frame).dt == Approx(0.02));
}

TEST_CASE("A long gap and a burst are clamped, and say so") {
  FrameClock clock(0.01);
  clock.advance(FrameBuilder(1).stamp(0).frame);
  const FrameInterval gap = clock.advance(FrameBuilder(400).stamp(4000 * kMs).frame);
  CHECK(gap.elapsed == Approx(4.0));
  CHECK(gap.dt == FrameClock::kMaxTimeStep);
  CHECK(gap.clamped);
  const FrameInterval burst = clock.advance(FrameBuilder(401).stamp(4000 * kMs + 1000).frame);
  CHECK(burst.dt == Approx(0.001));
  CHECK(burst.clamped);
}

TEST_CASE("After a restart of the tracker differences mean nothing") {
  FrameClock clock(0.01);
  clock.advance(FrameBuilder(5000).stamp(90'000 * kMs).frame);
  const FrameInterval interval = clock.advance(FrameBuilder(1).stamp(91'000 * kMs).after_restart().frame);
  CHECK(interval.dt == 0.01);
  CHECK_FALSE(interval.stamp_refused);
}

TEST_CASE("A tracker that changes its rate is noticed after a second, with and without stamps") {
  const bool stamped = GENERATE(true, false);
  const double rate_hz = GENERATE(50.0, 250.0);
  FrameClock clock(0.01);
  const auto period_ns = static_cast<std::uint64_t>(1e9 / rate_hz);
  std::mt19937 random(3);
  std::uniform_int_distribution<std::uint64_t> jitter_ns(0, period_ns / 4);
  std::uint64_t now_ns = 0;
  double elapsed = 0.0;
  double noticed = 0.0;
  for (std::uint32_t number = 1; elapsed < 3.0; ++number) {
    now_ns += period_ns;
    elapsed += 1.0 / rate_hz;
    FrameBuilder frame(number);
    frame.received(now_ns + jitter_ns(random));
    if (stamped) frame.stamp(now_ns);
    const FrameInterval interval = clock.advance(frame.frame);
    if (noticed > 0.0) CHECK(interval.dt == Approx(1.0 / rate_hz).epsilon(stamped ? 1e-6 : 0.15));
    if (const auto period = clock.changed_period()) {
      CHECK(noticed == 0.0);  // once
      CHECK(*period == Approx(1.0 / rate_hz).epsilon(0.15));
      noticed = elapsed;
      clock.adopt_period();
      CHECK(clock.period() == *period);
    }
  }
  CHECK(noticed > 1.0);
  CHECK(noticed < 1.6);
}

TEST_CASE("Jitter, loss and a passing stutter are no change of rate") {
  FrameClock clock(0.01);
  std::mt19937 random(5);
  std::uint64_t now_ns = 0;
  for (std::uint32_t number = 1; number < 2000; ++number) {
    const bool stutter = number > 500 && number < 540;
    now_ns += stutter ? 25 * kMs : 10 * kMs;
    if (random() % 10 == 0) continue;
    clock.advance(FrameBuilder(number).stamp(now_ns + random() % (3 * kMs)).frame);
    CHECK_FALSE(clock.changed_period().has_value());
  }
}

TEST_CASE("A rate change that the simulator refuses is offered again a second later") {
  FrameClock clock(0.01);
  int offers = 0;
  for (std::uint32_t number = 1; number <= 200; ++number) {
    clock.advance(FrameBuilder(number).stamp(number * 20 * kMs).frame);
    if (!clock.changed_period()) continue;
    ++offers;
    clock.keep_period();
  }
  CHECK(offers == 3);
  CHECK(clock.period() == 0.01);
}

TEST_CASE("What is longer under way than the quickest frame is said, also when clocks drift") {
  FrameClock clock(0.01);
  constexpr std::uint64_t kEpoch = 1'700'000'000'000 * kMs;  // the tracker's clock
  std::uint32_t number = 0;
  const auto delay_after = [&](double under_way_ms, double drift = 0.0) {
    ++number;
    const auto sent = static_cast<std::uint64_t>(10.0 * number * (1.0 + drift) * kMs);
    const auto received = static_cast<std::uint64_t>((10.0 * number + under_way_ms) * kMs);
    return 1e3 * clock.advance(FrameBuilder(number).stamp(kEpoch + sent).received(received).frame).delay;
  };
  CHECK(delay_after(5.0) == 0.0);
  CHECK(delay_after(3.0) == 0.0);
  CHECK(delay_after(4.0) == Approx(1.0).margin(0.05));
  CHECK(delay_after(253.0) == Approx(250.0).margin(0.5));
  for (int frame = 0; frame < 100; ++frame) delay_after(253.0);
  CHECK(delay_after(253.0) == Approx(249.0).margin(1.0));  // a second later still
  // A tracker's clock that is a ten-thousandth slow is no delay.
  number = 0;
  FrameClock drifting(0.01);
  double most = 0.0;
  for (std::uint32_t k = 1; k <= 20000; ++k)
    most = std::max(most, drifting
                              .advance(FrameBuilder(k)
                                           .stamp(kEpoch + static_cast<std::uint64_t>(10.0 * k * 0.9999 * kMs))
                                           .received(10 * k * kMs)
                                           .frame)
                              .delay);
  CHECK(most < 1e-4);
  // One that is set back is another clock.
  CHECK(clock.advance(FrameBuilder(500).stamp(5 * kMs).received(9'000 * kMs).frame).delay == 0.0);
}
