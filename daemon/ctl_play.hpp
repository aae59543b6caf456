#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// `tissuectl play`: streams recordings to tissued as a tracker would, and compares its answers with what was recorded.
void add_play_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
