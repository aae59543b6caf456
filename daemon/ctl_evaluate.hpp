#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// `tissuectl evaluate`: recorded trials through simulators in this process, scored as CSV and as a page.
void add_evaluate_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
