#include "protocol/text_fields.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace tissued::protocol {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::size_t kQuotedLength = 40;

template <class Number>
std::optional<Number> parse_whole(std::string_view text) {
  // std::from_chars knows no '+', and what follows it must not be a second sign.
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string in_quotes(std::string_view text) {
  std::string out = "'";
  for (const char c : text.substr(0, kQuotedLength)) out += c >= ' ' && c <= '~' ? c : '?';
  out += text.size() > kQuotedLength ? "...'" : "'";
  return out;
}

std::optional<double> parse_number(std::string_view text) {
  const auto value = parse_whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view text) { return parse_whole<std::int64_t>(text); }

void append_number(std::string& text, double value) {
  std::array<char, 32> digits{};
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), result.ptr);
}

}  // namespace tissued::protocol
