#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "daemon/mpi_ranks.hpp"

namespace tissued::daemon {

/// Does jobs 0 .. count - 1, each once, on `workers` threads of every rank. Rank 0 hands them out one at a time, to
/// whoever is free. job(i) must not throw; it runs beside others. on_done(i, result) is called on rank 0 only, in the
/// order in which they end. Once should_stop() says so on rank 0, none is begun. Returns on rank 0 the results by
/// number (null where a job was not begun), on the others nothing.
nlohmann::json share_jobs(const MpiRanks& ranks, int count, int workers, const std::function<nlohmann::json(int)>& job,
                          const std::function<void(int, const nlohmann::json&)>& on_done,
                          const std::function<bool()>& should_stop);

}  // namespace tissued::daemon
