#pragma once

namespace CLI {
class App;
}

namespace tissued::daemon {

/// `tissuectl effects`: the physical effects that `solve` can add and `diagnose` can find, and their numbers.
void add_effects_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
