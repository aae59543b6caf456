#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace tissued::protocol {

/// Walks comma-separated text line by line. Cells are trimmed; CRLF ends a line as LF does, a byte order mark at the
/// start is passed over. Quotes mean nothing: Nexus writes none.
class CsvReader {
 public:
  explicit CsvReader(std::string_view text);  ///< `text` must outlive this

  /// Goes to the next line, whether it holds anything or not; false at the end of the text.
  bool next();

  int line() const { return line_; }  ///< from 1; 0 before the first next()
  const std::vector<std::string_view>& cells() const { return cells_; }
  /// Cell `column` (from 0), or an empty one behind the end of the line.
  std::string_view cell(std::size_t column) const {
    return column < cells_.size() ? cells_[column] : std::string_view{};
  }
  /// The number of cells up to the last one that is not empty; spreadsheets pad every line to the longest.
  std::size_t width() const { return width_; }

 private:
  std::string_view rest_;
  std::vector<std::string_view> cells_;
  std::size_t width_ = 0;
  int line_ = 0;
};

}  // namespace tissued::protocol
