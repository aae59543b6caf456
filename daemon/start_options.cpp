#include "daemon/start_options.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "config/json_reader.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/version.hpp"

namespace tissued::daemon {

void declare_options(CLI::App& app, StartOptions& options) {
  app.set_version_flag("--version", std::string("tissued ") + kVersion);
  auto* source = app.add_option_group("source", "What to simulate");
  source->add_option("file,--config", options.config_file, "Configuration, JSON (see --print-schema)")
      ->type_name("FILE");
  source->add_option("--bundle", options.bundle_folder, "Bundle folder; everything else at its default")
      ->type_name("DIR");
  source->add_flag("--print-schema", options.print_schema, "Print the configuration's JSON Schema and exit");
  source->require_option(1);
  app.add_option("--model", options.model_file,
                 "model.json of `tissuectl diagnose`: simulate the physics that it found")
      ->type_name("FILE");
  app.add_option("--record", options.record_file,
                 "Record everything received and a summary of every answer; a file that does not exist yet")
      ->type_name("FILE");
  app.add_option("--keys", options.key_file, "Pre-shared keys, see `tissuectl key`: believe nobody else, and encrypt")
      ->type_name("FILE");
  app.add_flag("--insecure", options.insecure, "Let others than this machine be believed without a key");
  app.add_option("--set", options.overrides,
                 "Override a key of the configuration, e.g. material.poissons_ratio=0.42; may be repeated")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
  app.add_flag("--check", options.check, "Read and build everything, say so in one line, and exit");
  app.add_option("--tracker-port", options.tracker_port, "UDP port of the tracker's packets; 0: any free one");
  app.add_option("--client-port", options.client_port, "UDP port of the clients; 0: any free one");
  app.add_flag("--realtime", options.realtime,
               "Ask the kernel for real-time scheduling, against other work on this machine; short for --set "
               "realtime.enabled=true");
  app.add_option("--log-level", options.log_level, "What goes to the log")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "critical", "off"}));
}

config::DaemonConfig load_config(const StartOptions& options) {
  std::vector<std::string> overrides = options.overrides;
  // Said on the command line, paths are relative to the working folder; as text, whatever they look like.
  const auto set_path = [&overrides](const std::string& key, const std::string& path) {
    if (!path.empty()) overrides.push_back(key + "=" + config::Json(std::filesystem::absolute(path).string()).dump());
  };
  set_path("model", options.model_file);
  set_path("record", options.record_file);
  set_path("keys", options.key_file);
  if (options.insecure) overrides.push_back("insecure=true");
  if (options.tracker_port) overrides.push_back("tracker.port=" + std::to_string(*options.tracker_port));
  if (options.client_port) overrides.push_back("clients.port=" + std::to_string(*options.client_port));
  if (!options.log_level.empty()) overrides.push_back("log.level=" + options.log_level);
  if (options.realtime) overrides.push_back("realtime.enabled=true");
  config::DaemonConfig config = options.bundle_folder.empty()
                                    ? config::load_daemon_config(options.config_file, overrides)
                                    : config::config_for_bundle(options.bundle_folder, overrides);
  apply_model(config);
  return config;
}

}  // namespace tissued::daemon
