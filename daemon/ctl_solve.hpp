#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// `tissuectl solve`: the static answer to a push, without a daemon.
void add_solve_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
