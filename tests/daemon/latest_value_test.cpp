#include "daemon/latest_value.hpp"

#include <sys/select.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <thread>
#include <vector>

#include "daemon/event_fd.hpp"
#include "daemon/wake_up.hpp"

using tissued::daemon::EventFd;
using tissued::daemon::LatestValue;
using tissued::daemon::WakeUp;

namespace {

constexpr std::uint64_t kMix = 0x9E3779B97F4A7C15u;

// Wide enough that a torn hand-over would show: word i of value n must be n * kMix + i.
struct Wide {
  std::vector<std::uint64_t> words;
  explicit Wide(std::size_t size) : words(size) {}

  void fill(std::uint64_t n) {
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = n * kMix + i;
  }
  bool holds(std::uint64_t n) const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i] != n * kMix + i) return false;
    }
    return true;
  }
};

}  // namespace

TEST_CASE("A value is fetched once, and only the newest") {
  LatestValue<int> slot(7);
  CHECK_FALSE(slot.fetch());
  CHECK(slot.front() == 7);

  slot.back() = 1;
  CHECK_FALSE(slot.publish());
  slot.back() = 2;
  CHECK(slot.publish());  // 1 was never read
  slot.back() = 3;
  CHECK(slot.publish());

  CHECK(slot.fetch());
  CHECK(slot.front() == 3);
  CHECK_FALSE(slot.fetch());
  CHECK(slot.front() == 3);

  slot.back() = 4;
  CHECK_FALSE(slot.publish());
  CHECK(slot.fetch());
  CHECK(slot.front() == 4);
}

TEST_CASE("What the reader holds is not touched by any number of publications") {
  LatestValue<int> slot;
  slot.back() = 1;
  slot.publish();
  REQUIRE(slot.fetch());
  for (int n = 2; n < 20; ++n) {
    slot.back() = n;
    slot.publish();
    CHECK(slot.front() == 1);
  }
  REQUIRE(slot.fetch());
  CHECK(slot.front() == 19);
}

TEST_CASE("Two threads: values arrive whole, in order, the last one always, and every loss is reported") {
  constexpr std::uint64_t kCount = 20000;
  LatestValue<Wide> slot(std::size_t{61});
  WakeUp wake_up;
  std::uint64_t lost = 0;

  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kCount; ++n) {
      slot.back().fill(n);
      if (slot.publish()) ++lost;
      wake_up.notify();
    }
  });

  std::uint64_t read = 0;
  std::uint64_t newest = 0;
  bool whole = true;
  bool ascending = true;
  while (newest < kCount) {
    const auto ticket = wake_up.ticket();
    if (!slot.fetch()) {
      wake_up.wait(ticket);
      continue;
    }
    std::uint64_t found = newest + 1;
    while (found <= kCount && slot.front().words[0] != found * kMix) ++found;
    ascending = ascending && found <= kCount;
    if (!ascending) break;
    whole = whole && slot.front().holds(found);
    newest = found;
    ++read;
  }
  writer.join();
  CHECK(whole);
  CHECK(ascending);
  CHECK(read + lost == kCount);
}

TEST_CASE("A notification between ticket and wait is not missed") {
  WakeUp wake_up;
  const auto ticket = wake_up.ticket();
  wake_up.notify();
  wake_up.wait(ticket);  // would hang
  CHECK(wake_up.ticket() != ticket);
}

TEST_CASE("Two threads that wake each other in turn never miss a turn") {
  constexpr int kTurns = 2000;
  LatestValue<int> there(0);
  LatestValue<int> back(0);
  WakeUp wake_there;
  WakeUp wake_back;
  const auto take = [](LatestValue<int>& slot, WakeUp& wake_up) {
    for (;;) {
      const auto ticket = wake_up.ticket();
      if (slot.fetch()) return slot.front();
      wake_up.wait(ticket);
    }
  };
  std::thread echo([&] {
    for (int turn = 1; turn <= kTurns; ++turn) {
      back.back() = take(there, wake_there);
      back.publish();
      wake_back.notify();
    }
  });
  int wrong = 0;
  for (int turn = 1; turn <= kTurns; ++turn) {
    there.back() = turn;
    there.publish();
    wake_there.notify();
    if (take(back, wake_back) != turn) ++wrong;
  }
  echo.join();
  CHECK(wrong == 0);
}

TEST_CASE("An eventfd becomes readable when notified and unreadable when drained") {
  EventFd event;
  const auto readable = [&] {
    fd_set set;
    FD_ZERO(&set);
    FD_SET(event.descriptor(), &set);
    timeval now{};
    return ::select(event.descriptor() + 1, &set, nullptr, nullptr, &now) == 1;
  };
  CHECK_FALSE(readable());
  event.notify();
  event.notify();
  CHECK(readable());
  event.drain();
  CHECK_FALSE(readable());
}
