// Any bytes as a configuration and as a bundle's description: values within their schema, or one line that says why
// not.

#include <cstdint>
#include <string>
#include <string_view>

#include "config/config_error.hpp"
#include "config/document.hpp"
#include "config/schema.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::config;
using tissued::fuzz::promise;

namespace {

bool is_one_line(const std::string& message) {
  return message.starts_with("fuzz.json: ") && message.find('\n') == std::string::npos && message.size() < 4096;
}

void read_by(std::string_view schema, std::string_view text) {
  try {
    const Document document(parse_json(text, "fuzz.json"), "fuzz.json", {}, schema);
    const std::string written = document.root().dump();
    const Document again(parse_json(written, "again.json"), "again.json", {}, schema);
    promise(again.root() == document.root(), "what was read is read again as the same");
  } catch (const ConfigError& error) {
    promise(is_one_line(error.what()), "a refusal is one line that names the file");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  read_by(config_schema(), text);
  read_by(bundle_schema(), text);
  return 0;
}
