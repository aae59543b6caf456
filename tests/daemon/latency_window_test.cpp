#include "daemon/latency_window.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

using tissued::daemon::LatencyWindow;

TEST_CASE("An empty window has no latency") {
  const auto window = std::make_unique<LatencyWindow>();
  CHECK(window->size() == 0);
  CHECK(window->max_ns() == 0);
  CHECK(window->percentile_ns(0.99) == 0);
}

TEST_CASE("Percentiles agree with the sorted recent durations to 3 percent, from ns to minutes") {
  const std::size_t count = GENERATE(std::size_t{1}, std::size_t{2}, std::size_t{100}, LatencyWindow::kCapacity,
                                     LatencyWindow::kCapacity + 1, 3 * LatencyWindow::kCapacity - 17);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> exponent(0.0, 11.0);
  const auto window = std::make_unique<LatencyWindow>();
  std::vector<std::uint64_t> all;
  for (std::size_t i = 0; i < count; ++i) {
    all.push_back(static_cast<std::uint64_t>(std::pow(10.0, exponent(random))));
    window->add(all.back());
  }
  const std::size_t kept = std::min(count, LatencyWindow::kCapacity);
  std::vector<std::uint64_t> sorted(all.end() - static_cast<std::ptrdiff_t>(kept), all.end());
  std::sort(sorted.begin(), sorted.end());
  CHECK(window->size() == kept);
  CHECK(window->max_ns() == sorted.back());
  for (const double share : {0.001, 0.1, 0.25, 0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(kept)));
    const auto exact = static_cast<double>(sorted[rank - 1]);
    const auto estimate = static_cast<double>(window->percentile_ns(share));
    CHECK(estimate >= exact);
    CHECK(estimate <= exact * 1.0313 + 1.0);
  }
  CHECK(window->percentile_ns(1.0) == sorted.back());
}

TEST_CASE("One outlier moves the maximum and not the median, until it has left the window") {
  const auto window = std::make_unique<LatencyWindow>();
  window->add(~std::uint64_t{0});
  for (std::size_t i = 1; i < LatencyWindow::kCapacity; ++i) window->add(2'000'000);
  CHECK(window->percentile_ns(0.5) == Approx(2e6).epsilon(0.031));
  CHECK(window->percentile_ns(0.99) == Approx(2e6).epsilon(0.031));
  CHECK(window->max_ns() == ~std::uint64_t{0});
  window->add(2'000'000);
  CHECK(window->max_ns() == 2'000'000);
}
