#include "daemon/pad_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

using namespace tissued::daemon;

TEST_CASE("Pushes start from rest, stay between none and full, and do not jump") {
  for (const std::string_view name : push_pattern_names()) {
    const PushPattern pattern = push_pattern_of(name).value();
    const double period = 2.0, step = 1e-3;
    for (std::size_t pad = 0; pad < 3; ++pad) {
      INFO(name << ", pad " << pad);
      double before = push_share(pattern, pad, 3, 0.0, period), most = 0.0;
      CHECK(before == 0.0);
      for (double time = step; time < 14.0; time += step) {
        const double share = push_share(pattern, pad, 3, time, period);
        REQUIRE(share >= 0.0);
        REQUIRE(share <= 1.0);
        // A minimum-jerk move over a quarter period peaks at 1.875 / (period / 4).
        REQUIRE(std::abs(share - before) <= 1.9 / (period / 4.0) * step);
        most = std::max(most, share);
        before = share;
      }
      CHECK(most == (pattern == PushPattern::rest ? Approx(0.0) : Approx(1.0).margin(1e-5)));
    }
  }
}

TEST_CASE("In turn, one pad pushes at a time, each its period") {
  const double period = 4.0;
  for (std::size_t turn = 0; turn < 6; ++turn) {
    const double middle_of_hold = 1.0 + period * (double(turn) + 0.375);  // a second of rest comes first
    for (std::size_t pad = 0; pad < 3; ++pad) {
      CHECK(push_share(PushPattern::in_turn, pad, 3, middle_of_hold, period) == (pad == turn % 3 ? 1.0 : 0.0));
    }
  }
}

TEST_CASE("A pattern that there is not has no name") { CHECK_FALSE(push_pattern_of("sideways")); }
