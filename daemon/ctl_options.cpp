#include "daemon/ctl_options.hpp"

#include "config/config_error.hpp"
#include "protocol/client_header.hpp"
#include "protocol/vicon_stream.hpp"

namespace tissued::daemon {

CLI::Option* add_endpoint(CLI::App& app, const std::string& name, Endpoint& endpoint, const std::string& description) {
  const auto take = [&endpoint, name](const std::string& text) {
    const auto parsed = parse_endpoint(text);
    if (!parsed) throw CLI::ValidationError(name, "`" + text + "` is not HOST:PORT");
    endpoint = *parsed;
  };
  return app.add_option_function<std::string>(name, take, description)
      ->type_name("HOST:PORT")
      ->default_str(to_string(endpoint));
}

CLI::Option* add_keys(CLI::App& app, KeyOption& keys) {
  return app.add_option("--keys", keys.file, "Seal what is sent with the key of this file, see `tissuectl key`")
      ->type_name("FILE");
}

std::optional<protocol::SecretKey> KeyOption::key_for(config::KeyRole role) const {
  if (file.empty()) return std::nullopt;
  for (const config::PreSharedKey& key : config::read_key_file(file)) {
    if (key.role == role || key.role == config::KeyRole::both) return protocol::SecretKey(key.secret);
  }
  throw config::ConfigError(file + ": no key for a " + config::to_string(role));
}

CLI::Validator in_range(double low, double high) { return CLI::Range(low, high).description(""); }

std::string join_or(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

Endpoint default_tracker() { return {"127.0.0.1", protocol::kTrackerPort}; }
Endpoint default_clients() { return {"127.0.0.1", protocol::kClientPort}; }

}  // namespace tissued::daemon
