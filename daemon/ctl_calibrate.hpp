#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// Adds `tissuectl calibrate`; its exit code goes to `exit_code` when it has run.
void add_calibrate_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
