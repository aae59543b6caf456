#pragma once

namespace CLI {
class App;
}

namespace tissued::daemon {

/// `tissuectl export`: a bundle of what tissued has recorded.
void add_export_command(CLI::App& app, int& exit_code);

}  // namespace tissued::daemon
