#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// `tissuectl watch`: follows the predictions live.
void add_watch_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
