#include "daemon/job_pool.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace tissued::daemon {

void run_jobs(std::size_t count, int threads, const std::function<void(std::size_t)>& job,
              const std::function<void(std::size_t)>& on_done) {
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::vector<std::exception_ptr> failures(count);
  std::mutex done_mutex;
  std::size_t done = 0;

  const auto work = [&] {
    while (!failed.load()) {
      const std::size_t i = next.fetch_add(1);
      if (i >= count) return;
      try {
        job(i);
        const std::lock_guard lock(done_mutex);
        on_done(++done);
      } catch (...) {
        failures[i] = std::current_exception();
        failed.store(true);
      }
    }
  };
  std::vector<std::jthread> helpers;  // beside this thread
  for (int i = 1; i < threads && static_cast<std::size_t>(i) < count; ++i) helpers.emplace_back(work);
  work();
  helpers.clear();

  const auto failure = std::ranges::find_if(failures, [](const auto& f) { return f != nullptr; });
  if (failure != failures.end()) std::rethrow_exception(*failure);
}

}  // namespace tissued::daemon
