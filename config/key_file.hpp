// Pre-shared keys, one a line: `NAME ROLE 64-HEX-DIGITS`; lines that begin with `#`, and empty ones, say nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tissued::config {

inline constexpr std::size_t kMaxKeys = 64;
inline constexpr std::size_t kMaxKeyName = 24;  // characters, as in datagrams
inline constexpr std::size_t kMaxKeyFileBytes = 1 << 16;

// What the owner of a key may do.
enum class KeyRole : std::uint8_t {
  tracker,  // send tracker datagrams
  client,   // ask and subscribe
  both,
};

const char* to_string(KeyRole role);
std::optional<KeyRole> key_role_of(std::string_view word);

// Every copy is wiped from memory when it is dropped.
struct PreSharedKey {
  std::string name;  // 1 to 24 printable ASCII characters, no blanks
  KeyRole role = KeyRole::both;
  std::array<std::uint8_t, 32> secret{};

  ~PreSharedKey();
  friend bool operator==(const PreSharedKey&, const PreSharedKey&) = default;
};

// In the file's order; names and keys are unique; there may be none. Throws ConfigError: `FILE: REASON` where it cannot
// be read, is no regular file, or is one that group or others may read or write; `FILE:LINE: REASON` for a line. No
// message tells any of a key.
std::vector<PreSharedKey> read_key_file(const std::filesystem::path& path);

// The text of such a file; `source` is for messages. Throws ConfigError.
std::vector<PreSharedKey> parse_keys(std::string_view text, const std::string& source);

// A line for the file, without its end, with a key drawn by the system: it is for the caller to wipe. Throws
// ConfigError where `name` could not stand there, std::runtime_error where the system has no randomness.
std::string make_key_line(std::string_view name, KeyRole role);

}  // namespace tissued::config
