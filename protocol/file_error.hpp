#pragma once

#include <stdexcept>
#include <string>

namespace tissued::protocol {

/// A file that is refused. what() is one line: `FILE:LINE: REASON`, or `FILE: REASON` where no line is to blame.
class FileError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0 where the file as a whole, or a binary file, is at fault.
  FileError(const std::string& file, int line, const std::string& reason);

  const std::string& file() const { return file_; }
  const std::string& reason() const { return reason_; }
  int line() const { return line_; }

 private:
  std::string file_;
  std::string reason_;
  int line_;
};

}  // namespace tissued::protocol
