#pragma once

#include <CLI/CLI.hpp>

namespace tissued::daemon {

/// Adds `diagnose` and `predict`; what they end with is written to exit_code.
void add_diagnose_command(CLI::App& app, int& exit_code);
void add_predict_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
