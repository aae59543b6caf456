#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/watch_statistics.hpp"

namespace tissued::daemon {

/// How the conversation with the daemon stands.
struct Connection {
  std::string address;
  bool answering = false;
  double silent = 0.0;  ///< s since anything came from the daemon
};

/// "12 ms old", "3.4 s old".
std::string age_text(std::uint64_t age_ns);

/// ms; NaN where there is none.
struct DurationPercentiles {
  double p50, p99, max;
};
DurationPercentiles percentiles_ms(const LatencyWindow& window);

/// What goes on, in one line without its end: for where there is no terminal. `elapsed`: s since watching began.
std::string watch_line(const WatchStatistics& statistics, const Connection& connection, double elapsed,
                       std::uint64_t now_ns);

/// The same as one object.
nlohmann::json watch_json(const WatchStatistics& statistics, const Connection& connection, double elapsed,
                          std::uint64_t now_ns);

/// What is left to say at the end, with line ends: frames, mean and largest error per target, latencies.
std::string watch_summary(const WatchStatistics& statistics, double elapsed);
nlohmann::json watch_summary_json(const WatchStatistics& statistics, double elapsed);

}  // namespace tissued::daemon
