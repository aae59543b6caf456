#include "protocol/file_error.hpp"

namespace tissued::protocol {

namespace {

std::string located(const std::string& file, int line, const std::string& reason) {
  std::string message = file;
  if (line > 0) message.append(":").append(std::to_string(line));
  return message.append(": ").append(reason);
}

}  // namespace

FileError::FileError(const std::string& file, int line, const std::string& reason)
    : std::runtime_error(located(file, line, reason)), file_(file), reason_(reason), line_(line) {}

}  // namespace tissued::protocol
