#pragma once

#include <string>
#include <vector>

#include "daemon/terminal.hpp"
#include "daemon/watch_report.hpp"
#include "daemon/watch_statistics.hpp"

namespace tissued::daemon {

/// The page that `watch` shows in a terminal, as lines; nothing in it depends on the terminal but through `style`.
std::vector<std::string> watch_page(const WatchStatistics& statistics, const Connection& connection,
                                    const TerminalStyle& style, std::uint64_t now_ns);

}  // namespace tissued::daemon
