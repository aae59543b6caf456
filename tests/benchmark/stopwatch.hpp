#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <vector>

namespace tissued::benchmark {

// ms
inline double milliseconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

struct Times {
  double p50, p99, max;  // ms
};

inline Times times_of(int repeats, const std::function<void()>& work) {
  std::vector<double> all;
  for (int i = 0; i < repeats; ++i) all.push_back(milliseconds(work));
  std::sort(all.begin(), all.end());
  return {all[all.size() / 2], all[all.size() * 99 / 100], all.back()};
}

}  // namespace tissued::benchmark
