// Any bytes as a file of keys: keys that a file could hold, or one line that says why not and tells nothing of a key.

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>

#include "config/config_error.hpp"
#include "config/key_file.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::config;
using tissued::fuzz::promise;

namespace {

// So long a run of digits could be part of a key.
bool tells_digits(const std::string& message) {
  int run = 0;
  for (const char c : message) {
    run = std::isxdigit(static_cast<unsigned char>(c)) ? run + 1 : 0;
    if (run > static_cast<int>(kMaxKeyName)) return true;
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const auto keys = parse_keys(text, "keys");
    promise(keys.size() <= kMaxKeys, "there are not too many keys");
    std::set<std::string> names;
    for (const PreSharedKey& key : keys) {
      promise(!key.name.empty() && key.name.size() <= kMaxKeyName, "a name has 1 to 24 characters");
      promise(std::ranges::all_of(key.name, [](char c) { return c > ' ' && c <= '~'; }), "a name is printable");
      promise(names.insert(key.name).second, "names are unique");
    }
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    promise(message.starts_with("keys") && message.find('\n') == std::string::npos, "a refusal is one line");
    promise(!tells_digits(message), "a refusal tells nothing of a key");
  }
  return 0;
}
