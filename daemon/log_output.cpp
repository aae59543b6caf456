#include "daemon/log_output.hpp"

#include <spdlog/async.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "config/config_error.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPatternOfTerminal = "tissued: %l: %v";
constexpr const char* kPatternOfFile = "%Y-%m-%dT%H:%M:%S.%e%z %l: %v";

spdlog::sink_ptr open_file(const config::DaemonConfig& config) {
  const fs::path& file = config.log.file;
  const auto refuse = [&](const std::string& reason) {
    throw config::ConfigError(config.source + ": /log/file: " + file.string() + ": " + reason);
  };
  std::error_code ignored;
  // A pipe would wait for its reader, and a device does not like to be renamed.
  if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored)) refuse("is not a file");
  try {
    return std::make_shared<spdlog::sinks::rotating_file_sink_mt>(file.string(), config.log.max_bytes,
                                                                  static_cast<std::size_t>(config.log.files - 1));
  } catch (const spdlog::spdlog_ex& error) {
    refuse(error.what());
  }
  return nullptr;
}

void log_to(spdlog::sink_ptr sink, const char* pattern, config::LogLevel level) {
  spdlog::init_thread_pool(256, 1);
  const auto logger = std::make_shared<spdlog::async_logger>("tissued", std::move(sink), spdlog::thread_pool(),
                                                             spdlog::async_overflow_policy::overrun_oldest);
  logger->set_pattern(pattern);
  logger->set_level(static_cast<spdlog::level::level_enum>(level));
  logger->flush_on(spdlog::level::trace);  // messages are few, and the last ones matter most
  spdlog::set_default_logger(logger);
}

}  // namespace

void start_logging(const config::DaemonConfig& config) {
  if (config.log.file.empty()) return start_logging_to_stderr(config.log.level);
  log_to(open_file(config), kPatternOfFile, config.log.level);
}

void set_log_level(config::LogLevel level) {
  spdlog::default_logger()->set_level(static_cast<spdlog::level::level_enum>(level));
}

void start_logging_to_stderr(config::LogLevel level) {
  log_to(std::make_shared<spdlog::sinks::stderr_sink_mt>(), kPatternOfTerminal, level);
}

}  // namespace tissued::daemon
