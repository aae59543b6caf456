#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace tissued::tests {

// `text` with its one `from` replaced; throws where there is none or more than one, so that no test edits nothing.
inline std::string edited(std::string_view text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  if (at == std::string_view::npos || text.find(from, at + 1) != std::string_view::npos) {
    throw std::logic_error("not exactly one '" + std::string(from) + "'");
  }
  std::string out(text);
  return out.replace(at, from.size(), to);
}

// Every line end as Windows writes it.
inline std::string with_crlf(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\n') out += '\r';
    out += c;
  }
  return out;
}

}  // namespace tissued::tests
