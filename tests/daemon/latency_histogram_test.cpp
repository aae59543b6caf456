#include "daemon/latency_histogram.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

using tissued::daemon::LatencyHistogram;

TEST_CASE("An empty histogram has no latency") {
  LatencyHistogram histogram;
  CHECK(histogram.count() == 0);
  CHECK(histogram.max_ns() == 0);
  CHECK(histogram.percentile_ns(0.99) == 0);
}

TEST_CASE("Percentiles agree with the sorted list to 3 percent, from ns to minutes") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> exponent(0.0, 11.0);
  LatencyHistogram histogram;
  std::vector<std::uint64_t> sorted;
  for (int i = 0; i < 20000; ++i) {
    sorted.push_back(static_cast<std::uint64_t>(std::pow(10.0, exponent(random))));
    histogram.add(sorted.back());
  }
  std::sort(sorted.begin(), sorted.end());
  CHECK(histogram.count() == sorted.size());
  CHECK(histogram.max_ns() == sorted.back());
  for (const double share : {0.001, 0.1, 0.25, 0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
    const auto exact = static_cast<double>(sorted[rank - 1]);
    const auto estimate = static_cast<double>(histogram.percentile_ns(share));
    CHECK(estimate >= exact);
    CHECK(estimate <= exact * 1.0313 + 1.0);
  }
  CHECK(histogram.percentile_ns(1.0) == sorted.back());
}

TEST_CASE("One outlier moves the maximum and not the median") {
  LatencyHistogram histogram;
  for (int i = 0; i < 999; ++i) histogram.add(2'000'000);
  histogram.add(~std::uint64_t{0});
  CHECK(histogram.percentile_ns(0.5) == Approx(2e6).epsilon(0.031));
  CHECK(histogram.percentile_ns(0.99) == Approx(2e6).epsilon(0.031));
  CHECK(histogram.max_ns() == ~std::uint64_t{0});
}
