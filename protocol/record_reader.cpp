#include "protocol/record_reader.hpp"

#include <limits>

#include "protocol/text_fields.hpp"

namespace tissued::protocol {

bool RecordReader::next() {
  while (!rest_.empty()) {
    const std::size_t length = rest_.find('\n');
    std::string_view text = rest_.substr(0, length);
    rest_.remove_prefix(length == std::string_view::npos ? rest_.size() : length + 1);
    ++line_;
    if (comment_ != '\0') text = text.substr(0, text.find(comment_));
    record_ = fields_ = trimmed(text);
    if (!record_.empty()) return true;
  }
  record_ = fields_ = {};
  return false;
}

void RecordReader::require_next(const std::string& what) {
  if (!next()) fail("the file ends before " + what);
}

void RecordReader::require_next(const char* what, std::size_t i, std::size_t count) {
  if (!next()) fail("the file ends before " + nth_of(what, i, count));
}

std::string_view RecordReader::field(const char* what) {
  if (fields_.empty()) fail(std::string("the line ends before the ") + what);
  const std::string_view text = fields_.substr(0, fields_.find_first_of(" \t"));
  fields_ = trimmed(fields_.substr(text.size()));
  return text;
}

double RecordReader::number(const char* what) {
  const std::string_view text = field(what);
  const auto value = parse_number(text);
  if (!value) fail(std::string(what) + ": " + in_quotes(text) + " is not a finite number");
  return *value;
}

std::int64_t RecordReader::integer(const char* what) {
  const std::string_view text = field(what);
  const auto value = parse_integer(text);
  if (!value) fail(std::string(what) + ": " + in_quotes(text) + " is not an integer");
  return *value;
}

int RecordReader::small_integer(const char* what) {
  const std::int64_t value = integer(what);
  if (value < -std::numeric_limits<int>::max() || value > std::numeric_limits<int>::max()) {
    fail(std::string(what) + ": " + std::to_string(value) + " is out of range");
  }
  return static_cast<int>(value);
}

std::size_t RecordReader::count(const char* what, std::size_t bytes_each) {
  const std::int64_t value = integer(what);
  if (value < 0) fail(std::string(what) + ": " + std::to_string(value) + " is negative");
  // Fields of the current line count as what may follow, too; one byte more for a last line without its end.
  const std::size_t bytes = rest_.size() + fields_.size() + 1;
  if (static_cast<std::uint64_t>(value) > bytes / bytes_each ||
      static_cast<std::uint64_t>(value) > std::numeric_limits<std::int32_t>::max()) {
    fail(std::string(what) + ": " + std::to_string(value) + " is more than the rest of the file can hold");
  }
  return static_cast<std::size_t>(value);
}

std::string nth_of(const char* what, std::size_t i, std::size_t count) {
  return std::string(what) + " " + std::to_string(i + 1) + " of " + std::to_string(count);
}

void RecordReader::end_record() const {
  if (!fields_.empty()) fail(in_quotes(fields_) + " is more than this line should hold");
}

}  // namespace tissued::protocol
