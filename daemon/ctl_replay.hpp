#pragma once

namespace CLI {
class App;
}

namespace tissued::daemon {

/// `tissuectl replay`: what tissued has recorded once more, bit for bit.
void add_replay_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
