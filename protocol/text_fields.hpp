#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tissued::protocol {

/// `text` without the blanks, tabs and carriage returns around it.
std::string_view trimmed(std::string_view text);

/// `text` in quotes for a one-line message: unprintable bytes as '?', cut to 40 characters.
std::string in_quotes(std::string_view text);

/// The finite number that the whole of `text` spells in decimal, or nothing. A leading '+' is allowed.
std::optional<double> parse_number(std::string_view text);

/// The integer that the whole of `text` spells in decimal, or nothing. A leading '+' is allowed.
std::optional<std::int64_t> parse_integer(std::string_view text);

/// Appends `value` in the fewest digits that read back to the same bits.
void append_number(std::string& text, double value);

}  // namespace tissued::protocol
