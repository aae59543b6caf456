#pragma once

#include "config/daemon_config.hpp"

namespace tissued::daemon {

/// Where spdlog's default logger writes from now on: standard error, or a file that is renamed when it has grown.
/// A thread of its own writes: a terminal that does not read, or a disk that is full, must not hold up answers. What it
/// cannot take is lost. Throws config::ConfigError where the file cannot be written.
void start_logging(const config::DaemonConfig& config);

void set_log_level(config::LogLevel level);

/// The same while nothing is served: to standard error, whatever the configuration says, and no file is touched.
void start_logging_to_stderr(config::LogLevel level);

}  // namespace tissued::daemon
