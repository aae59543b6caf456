#include "daemon/job_pool.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <latch>
#include <stdexcept>
#include <string>
#include <vector>

using tissued::daemon::run_jobs;

TEST_CASE("Every job is done once, whatever the number of threads") {
  for (const int threads : {0, 1, 2, 7, 200}) {
    std::vector<std::atomic<int>> times(100);
    std::vector<std::size_t> told;
    run_jobs(
        times.size(), threads, [&](std::size_t i) { ++times[i]; }, [&](std::size_t done) { told.push_back(done); });
    for (const auto& count : times) CHECK(count == 1);
    REQUIRE(told.size() == 100);
    for (std::size_t i = 0; i < told.size(); ++i) CHECK(told[i] == i + 1);
  }
}

TEST_CASE("No jobs are done at once") {
  run_jobs(
      0, 4, [](std::size_t) { FAIL(); }, [](std::size_t) { FAIL(); });
}

TEST_CASE("As many jobs run at a time as there are threads") {
  // Each waits for the other two: with fewer threads this would never end.
  std::latch all_here(3);
  run_jobs(
      3, 3, [&](std::size_t) { all_here.arrive_and_wait(); }, [](std::size_t) {});
  CHECK(all_here.try_wait());
}

TEST_CASE("A job that throws ends the work, and its exception arrives") {
  for (const int threads : {1, 4}) {
    std::atomic<int> begun{0};
    const auto job = [&](std::size_t i) {
      ++begun;
      if (i >= 10) throw std::runtime_error("job " + std::to_string(i));
    };
    std::string message;
    try {
      run_jobs(1000, threads, job, [](std::size_t) {});
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    CHECK(message == "job 10");
    CHECK(begun < 100);
  }
}
