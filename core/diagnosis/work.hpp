// Who does what, for how long, and what is told of it, while a search runs.
#pragma once

#include <omp.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "core/diagnosis/search.hpp"

namespace tissued::core {

// Jobs over threads, until time is over; what is said of them.
class Work {
 public:
  explicit Work(const SearchOptions& options) : options_(&options), begin_(clock()) {
    // A fit takes its time: what is under way must hear of the end, too.
    watch_ = std::jthread([this](const std::stop_token& done) {
      while (!done.stop_requested() && !over()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    });
  }

  explicit Work(const SearchOptions&&) = delete;  // which it goes on reading

  double seconds() const { return clock() - begin_; }
  double share_of_budget() const { return seconds() / options_->budget; }
  bool over() {
    if (seconds() > options_->budget - kept_ || (options_->interrupted != nullptr && options_->interrupted->load()))
      stop = true;
    return stop;
  }
  // Of the budget, for what comes after the search.
  void keep(double seconds) { kept_ = seconds; }
  int threads() const { return options_->threads > 0 ? options_->threads : omp_get_num_procs(); }
  void tell(double share, const std::string& what) {
    if (!options_->progress) return;
    const std::lock_guard lock(mutex_);
    share_ = std::max(share_, share);
    options_->progress(share_, what);
  }
  // Independent jobs over the threads; none is begun when time is over.
  void all(std::size_t count, const std::function<void(std::size_t)>& job, double from, double to,
           const std::function<std::string(std::size_t)>& what) {
    std::size_t done = 0;
// A single job may take the threads for itself.
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads()) if (count > 1)
    for (std::size_t i = 0; i < count; ++i) {
      if (over()) continue;
      job(i);
      std::size_t now = 0;
#pragma omp atomic capture
      now = ++done;
      tell(from + (to - from) * static_cast<double>(now) / static_cast<double>(count), what(i));
    }
  }
  std::atomic<bool> stop{false};

 private:
  // s, from anywhere.
  double clock() const {
    timespec now{};
    clock_gettime(options_->processor_time ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
    const double seconds = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
    return options_->processor_time ? seconds / threads() : seconds;
  }

  const SearchOptions* options_;
  double begin_;
  std::atomic<double> kept_{0.0};
  std::mutex mutex_;
  double share_ = 0.0;
  std::jthread watch_;  // last: ends before what it looks at
};

// A part of the work that is not to take it all: over when so much of the budget is spent, or when the work is.
class Allotment {
 public:
  Allotment(Work& work, double share_of_budget) {
    const auto is_spent = [&work, share_of_budget] { return work.over() || work.share_of_budget() > share_of_budget; };
    over = is_spent();
    watch_ = std::jthread([this, is_spent](const std::stop_token& done) {
      while (!done.stop_requested() && !over) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        over = is_spent();
      }
    });
  }

  std::atomic<bool> over{false};

 private:
  std::jthread watch_;  // last: ends before what it looks at
};

}  // namespace tissued::core
