#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tissued::daemon {

/// `text` as it must stand between tags or in a quoted attribute.
std::string escape_html(std::string_view text);

/// `<name>content</name>`, the content as it is: HTML. attributes: `class="a"` and so on.
std::string element(std::string_view name, std::string_view content, std::string_view attributes = {});

/// A whole page in English. body: HTML, within <main>; style: CSS.
std::string html_page(std::string_view title, std::string_view style, std::string_view body);

/// An HTML table with one row of headings. Cells are HTML; the first `text_columns` are left-aligned, all others are
/// numbers, to the right.
class HtmlTable {
 public:
  HtmlTable(std::vector<std::string> headings, std::size_t text_columns)
      : headings_(std::move(headings)), text_columns_(text_columns) {}

  void add_row(std::vector<std::string> cells) { rows_.push_back({std::move(cells), false}); }
  /// Set apart from the rows above: a mean, a sum.
  void add_total(std::vector<std::string> cells) { rows_.push_back({std::move(cells), true}); }
  std::string html(std::string_view caption) const;

 private:
  struct Row {
    std::vector<std::string> cells;
    bool total;
  };
  std::string cells_html(std::string_view tag, const std::vector<std::string>& cells) const;

  std::vector<std::string> headings_;
  std::size_t text_columns_;
  std::vector<Row> rows_;
};

}  // namespace tissued::daemon
