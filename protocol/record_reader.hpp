#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "protocol/mesh_file.hpp"

namespace tissued::protocol {

/// `node 3 of 8`, for messages; `i` counts from 0.
std::string nth_of(const char* what, std::size_t i, std::size_t count);

/// Walks the text of a mesh file line by line and each line field by field; fields are parted by blanks. Blank lines
/// are passed over, CRLF ends a line as LF does. Every refusal is a MeshError at the current line.
class RecordReader {
 public:
  /// `comment` starts a comment that ends with the line; '\0' where the format has none. `text` must outlive this.
  RecordReader(std::string_view text, std::string file, char comment = '\0')
      : file_(std::move(file)), rest_(text), comment_(comment) {}

  /// Goes to the next line that holds anything; false at the end of the text, where line() stays at the last line.
  bool next();
  /// The same, but the end of the text is refused: `what` says what is missing there.
  void require_next(const std::string& what);
  /// The same for entry `i` (from 0) of a list of `count`.
  void require_next(const char* what, std::size_t i, std::size_t count);

  std::string_view record() const { return record_; }  ///< the whole current line, trimmed
  int line() const { return line_; }                   ///< from 1; 0 before the first next()
  const std::string& file() const { return file_; }

  /// The next field of the current line; `what` names it in a refusal.
  std::string_view field(const char* what);
  double number(const char* what);
  std::int64_t integer(const char* what);
  /// An integer whose size fits an int, whatever its sign.
  int small_integer(const char* what);
  /// How many lines (or fields) follow. Refused where the rest of the file could not hold them at `bytes_each`, so that
  /// no count makes us reserve more than a small multiple of the file's size.
  std::size_t count(const char* what, std::size_t bytes_each);

  bool has_field() const { return !fields_.empty(); }
  /// All fields left of the current line, as one text; the line then counts as read.
  std::string_view take_rest() { return std::exchange(fields_, {}); }
  /// Refuses a field left over.
  void end_record() const;

  [[noreturn]] void fail(const std::string& reason) const { throw MeshError(file_, line_, reason); }

 private:
  std::string file_;
  std::string_view rest_;    // text after the current line
  std::string_view record_;  // current line
  std::string_view fields_;  // what is left of the current line, starting at a field
  int line_ = 0;
  char comment_;
};

}  // namespace tissued::protocol
