#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// `tissuectl track`: a simulated tracker beside a simulated tissue.
void add_track_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
