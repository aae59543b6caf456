#pragma once

#include <cstddef>
#include <functional>

namespace tissued::daemon {

/// Does jobs 0 .. count - 1, each once, on `threads` threads (at least one), begun in the order of their numbers.
/// job(i) may run beside any other job. on_done(done) is told after every job how many are done, by one thread at a
/// time. Returns when all are done. Where jobs throw, no new one is begun and the exception of the lowest number is
/// thrown on.
void run_jobs(std::size_t count, int threads, const std::function<void(std::size_t)>& job,
              const std::function<void(std::size_t)>& on_done);

}  // namespace tissued::daemon
