// JSON text -> values, stricter than JSON asks for: no key twice, no deep nesting, no huge text.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace tissued::config {

// Keeps the file's order: pads, markers and targets are numbered by it.
using Json = nlohmann::ordered_json;
using JsonPointer = Json::json_pointer;

inline constexpr std::size_t kMaxJsonBytes = 1 << 20;
inline constexpr std::size_t kMaxJsonDepth = 16;
inline constexpr std::size_t kMaxJsonString = 1024;  // bytes; bounds the recursion of the schema's regular expressions

// Reads a regular file. Throws ConfigError.
Json read_json(const std::filesystem::path& path);

// `source` is for messages. Throws ConfigError: syntax (with line and column), invalid UTF-8, U+0000, numbers too large
// for a double, the limits above, a key given twice.
Json parse_json(std::string_view text, const std::string& source);

// A value as a message shows it: compact JSON, clipped.
std::string quoted(const Json& value);

// Text from a file or a command line as a message may show it: printable ASCII on one line, clipped to `max_bytes`.
std::string one_line(std::string text, std::size_t max_bytes);

}  // namespace tissued::config
