#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/key_file.hpp"
#include "daemon/endpoint.hpp"
#include "protocol/secret_key.hpp"

namespace tissued::daemon {

/// Exit codes of tissuectl.
enum ExitCode : int { kSuccess = 0, kFailure = 1, kUsage = 2 };

/// A command line that cannot be meant; what() says why. Ends tissuectl with kUsage.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An option HOST:PORT; its default is what `endpoint` holds.
CLI::Option* add_endpoint(CLI::App& app, const std::string& name, Endpoint& endpoint, const std::string& description);

/// Option --keys FILE: everything goes to tissued sealed with the first key of that file that has the role.
struct KeyOption {
  std::string file;  ///< empty: nothing is sealed

  /// Throws config::ConfigError where the file has no such key.
  std::optional<protocol::SecretKey> key_for(config::KeyRole role) const;
};
CLI::Option* add_keys(CLI::App& app, KeyOption& keys);

/// Accepts numbers from `low` to `high`; says so when it refuses, not in the help.
CLI::Validator in_range(double low, double high);

/// `a, b or c`, for messages and help.
std::string join_or(const std::vector<std::string>& names);

/// The default addresses of tissued on this machine.
Endpoint default_tracker();
Endpoint default_clients();

}  // namespace tissued::daemon
