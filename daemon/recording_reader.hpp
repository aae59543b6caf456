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
  /// The next record that is whole; nothing at the end. The configuration comes once, and parts are not told.
  std::optional<protocol::SessionRecord> next();

  std::size_t parts() const { return readers_.size(); }
  /// See protocol::SessionReader; of all files so far.
  std::size_t damaged_bytes() const;
  bool torn() const { return readers_.back().torn(); }

 private:
  std::vector<std::string> contents_;
  std::vector<protocol::SessionReader> readers_;
  std::size_t part_ = 0;  // at hand
};

}  // namespace tissued::daemon
