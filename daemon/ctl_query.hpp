#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// `tissuectl query`: asks tissued once.
void add_query_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
