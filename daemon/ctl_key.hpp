#pragma once

namespace CLI {
class App;
}

namespace tissued::daemon {

/// `tissuectl key`: a line for the file of pre-shared keys.
void add_key_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
