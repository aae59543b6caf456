#include "daemon/recorded_config.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include "config/json_reader.hpp"
#include "daemon/session_recorder.hpp"

namespace tissued::daemon {

config::DaemonConfig recorded_config(const RecordingReader& reader, const std::filesystem::path& file,
                                     const std::filesystem::path& bundle) {
  std::vector<std::string> overrides;
  if (!bundle.empty()) overrides.push_back("bundle=" + config::Json(bundle.string()).dump());
  config::DaemonConfig config = config::config_from_text(reader.configuration(), file.string(), overrides);
  if (hash_of_bundle(config.bundle) != reader.header().bundle_hash)
    throw std::runtime_error(config.bundle.folder.string() + ": not the bundle that " + file.string() +
                             " was recorded with, or changed since");
  return config;
}

}  // namespace tissued::daemon
