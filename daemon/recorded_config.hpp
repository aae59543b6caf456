#pragma once

#include <filesystem>

#include "config/daemon_config.hpp"
#include "daemon/recording_reader.hpp"

namespace tissued::daemon {

/// What the daemon ran by when it wrote the recording `file`, with the bundle where it was then or, unless that is
/// empty, `bundle`; its model is not applied. Throws std::runtime_error where the bundle's hash is another,
/// config::ConfigError, protocol::FileError.
config::DaemonConfig recorded_config(const RecordingReader& reader, const std::filesystem::path& file,
                                     const std::filesystem::path& bundle);

}  // namespace tissued::daemon
