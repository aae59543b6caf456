#include "protocol/replay_window.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <set>
#include <string>

using namespace tissued::protocol;

TEST_CASE("a counter is taken once") {
  ReplayWindow window;
  CHECK(window.take(5) == ReplayVerdict::fresh);
  CHECK(window.take(5) == ReplayVerdict::replayed);
  CHECK(window.take(7) == ReplayVerdict::fresh);
  CHECK(window.take(6) == ReplayVerdict::fresh);
  CHECK(window.take(6) == ReplayVerdict::replayed);
  CHECK(window.take(0) == ReplayVerdict::fresh);
}

TEST_CASE("the replay window holds 1024 counters, the newest and 1023 before it") {
  ReplayWindow window;
  CHECK(window.take(2000) == ReplayVerdict::fresh);
  CHECK(window.take(2000 - 1023) == ReplayVerdict::fresh);
  CHECK(window.take(2000 - 1023) == ReplayVerdict::replayed);
  CHECK(window.take(2000 - 1024) == ReplayVerdict::too_old);
  CHECK(window.take(2001) == ReplayVerdict::fresh);
  CHECK(window.take(2000 - 1023) == ReplayVerdict::too_old);
  CHECK(window.take(2001 - 1023) == ReplayVerdict::fresh);
}

TEST_CASE("jumps by a window, by less and by more leave nothing behind that was not taken") {
  for (const std::uint64_t jump : {1023U, 1024U, 1025U, 2048U, 100000U}) {
    CAPTURE(jump);
    ReplayWindow window;
    for (std::uint64_t counter = 0; counter < 1024; ++counter) window.take(counter);
    CHECK(window.take(1023 + jump) == ReplayVerdict::fresh);
    for (std::uint64_t counter = 1024; counter < 1023 + jump; ++counter) {
      const bool within = 1023 + jump - counter < 1024;
      REQUIRE(window.take(counter) == (within ? ReplayVerdict::fresh : ReplayVerdict::too_old));
    }
    CHECK(window.take(1023) == (jump < 1024 ? ReplayVerdict::replayed : ReplayVerdict::too_old));
  }
}

TEST_CASE("the last counter there is ends a session, it does not wrap") {
  ReplayWindow window;
  const std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  CHECK(window.take(0) == ReplayVerdict::fresh);
  CHECK(window.take(last) == ReplayVerdict::fresh);
  CHECK(window.take(last) == ReplayVerdict::replayed);
  CHECK(window.take(0) == ReplayVerdict::too_old);
  CHECK(window.take(last - 1) == ReplayVerdict::fresh);
}

TEST_CASE("the replay window agrees with a set that forgets nothing") {
  std::mt19937_64 random(11);
  for (const int largest_step : {1, 3, 40, 1500}) {
    ReplayWindow window;
    std::set<std::uint64_t> taken;
    std::uint64_t base = 5000;
    for (int i = 0; i < 20000; ++i) {
      base += std::uniform_int_distribution<std::uint64_t>(0, static_cast<std::uint64_t>(largest_step))(random);
      const std::uint64_t counter = base - std::uniform_int_distribution<std::uint64_t>(0, 1100)(random);
      ReplayVerdict expected = taken.count(counter) > 0 ? ReplayVerdict::replayed : ReplayVerdict::fresh;
      if (!taken.empty() && counter + 1024 <= *taken.rbegin()) expected = ReplayVerdict::too_old;
      REQUIRE(std::string(to_string(window.take(counter))) == to_string(expected));
      if (expected == ReplayVerdict::fresh) taken.insert(counter);
    }
  }
}
