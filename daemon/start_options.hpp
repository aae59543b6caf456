#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/daemon_config.hpp"

namespace CLI {
class App;
}

namespace tissued::daemon {

/// What the command line of `tissued` says.
struct StartOptions {
  std::string config_file;
  std::string bundle_folder;
  std::string model_file;
  std::string record_file;
  std::string key_file;
  std::vector<std::string> overrides;  ///< `key=value`, of the configuration
  std::optional<std::uint16_t> tracker_port;
  std::optional<std::uint16_t> client_port;
  std::string log_level;
  bool realtime = false;
  bool insecure = false;
  bool check = false;
  bool print_schema = false;
};

/// Declares the command line; `options` is filled when it is parsed and must live until then.
void declare_options(CLI::App& app, StartOptions& options);

/// The configuration as the command line leaves it, its model applied. Throws config::ConfigError.
config::DaemonConfig load_config(const StartOptions& options);

}  // namespace tissued::daemon
