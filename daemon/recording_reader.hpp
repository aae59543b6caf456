#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "protocol/session_file.hpp"

namespace tissued::daemon {

/// Reads what SessionRecorder wrote, through all files of a recording. They are read whole: records lie in this.
class RecordingReader {
 public:
  /// file: the first of the recording. Throws protocol::FileError where it cannot be read, std::runtime_error where it
  /// is none, goes on with another's, or misses one.
  explicit RecordingReader(const std::filesystem::path& file);

  const protocol::SessionHeader& header() const { return readers_.front().header(); }
  /// JSON, what the daemon ran by: see config::config_from_text.
  const std::string& configuration() const { return configuration_; }
  /// The next record that is whole; nothing at the end. Neither the configuration nor parts are told.
  std::optional<protocol::SessionRecord> next();

  std::size_t parts() const { return readers_.size(); }
  /// See protocol::SessionReader; of all files so far.
  std::size_t damaged_bytes() const;
  bool torn() const { return torn_ || readers_.back().torn(); }

 private:
  std::vector<std::string> contents_;
  std::vector<protocol::SessionReader> readers_;
  std::string configuration_;
  std::size_t part_ = 0;  // at hand
  bool torn_ = false;     // a last part was created, and not begun
};

}  // namespace tissued::daemon
