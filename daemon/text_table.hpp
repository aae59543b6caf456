#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tissued::daemon {

/// Columns on a terminal as wide as `text` needs: code points, not bytes. Escape sequences (ESC [ ... letter) take
/// none.
std::size_t display_width(std::string_view text);

/// `text` with blanks before it (`right`) or behind it up to `width` columns; longer text is left as it is.
std::string pad_to(std::string_view text, std::size_t width, bool right);

/// `value` with `digits` decimals; "-" where it is not finite.
std::string fixed(double value, int digits);

/// A plain table: cells parted by two blanks, the first column left-aligned, all others to the right.
class TextTable {
 public:
  void add_row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// One line per row, each with its end; columns as wide as their widest cell.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace tissued::daemon
