#include "daemon/html.hpp"

namespace tissued::daemon {

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string element(std::string_view name, std::string_view content, std::string_view attributes) {
  std::string html = "<";
  html += name;
  if (!attributes.empty()) html += ' ';
  html += attributes;
  html += '>';
  html += content;
  html += "</";
  html += name;
  html += ">\n";
  return html;
}

std::string html_page(std::string_view title, std::string_view style, std::string_view body) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n" +
         element("title", escape_html(title)) + "\n" + element("style", style) + "</head>\n<body>\n" +
         element("main", body) + "</body>\n</html>\n";
}

std::string HtmlTable::cells_html(std::string_view tag, const std::vector<std::string>& cells) const {
  std::string html;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    html += element(tag, cells[i], i < text_columns_ ? "" : "class=\"number\"");
  }
  return html;
}

std::string HtmlTable::html(std::string_view caption) const {
  std::string body;
  for (const Row& row : rows_) {
    body += element("tr", cells_html("td", row.cells), row.total ? "class=\"total\"" : "");
  }
  const std::string head = element("thead", element("tr", cells_html("th", headings_)));
  const std::string table = element("table", head + element("tbody", body));
  return element("figure", element("figcaption", caption) + element("div", table, "class=\"table\""));
}

}  // namespace tissued::daemon
