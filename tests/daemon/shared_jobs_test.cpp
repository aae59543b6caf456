#include "daemon/shared_jobs.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <vector>

using namespace tissued::daemon;
using nlohmann::json;

TEST_CASE("Every job is done once, and results are kept by number") {
  const MpiRanks ranks;
  std::vector<std::atomic<int>> times(20);
  int told = 0;
  const json results = share_jobs(
      ranks, 20, 3,
      [&](int i) {
        ++times[static_cast<std::size_t>(i)];
        return json(i * i);
      },
      [&](int i, const json& result) {
        ++told;
        CHECK(result == i * i);
      },
      [] { return false; });
  CHECK(told == 20);
  REQUIRE(results.size() == 20);
  for (int i = 0; i < 20; ++i) {
    CHECK(times[static_cast<std::size_t>(i)] == 1);
    CHECK(results[static_cast<std::size_t>(i)] == i * i);
  }
}

TEST_CASE("After a stop none is begun, and those that were are told of") {
  const MpiRanks ranks;
  std::atomic<bool> stop{false};
  const json results = share_jobs(
      ranks, 10, 1,
      [&](int i) {
        if (i == 3) stop = true;
        return json(i);
      },
      [](int, const json&) {}, [&] { return stop.load(); });
  CHECK(results[3] == 3);
  for (std::size_t i = 4; i < 10; ++i) CHECK(results[i].is_null());
}

TEST_CASE("More workers than jobs end, too") {
  const MpiRanks ranks;
  const json results = share_jobs(
      ranks, 1, 8, [](int) { return json(7); }, [](int, const json&) {}, [] { return false; });
  CHECK(results == json::array({7}));
}
