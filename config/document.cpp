#include "config/document.hpp"

#include <sstream>
#include <utility>

#include "config/config_error.hpp"
#include "config/validation.hpp"

namespace tissued::config {
namespace {

std::vector<std::string> split(const std::string& dotted) {
  std::vector<std::string> parts;
  std::istringstream stream(dotted);
  for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
  return parts;
}

// A number, a list, true ... where the text is JSON; else the text itself, so that names need no quotes.
Json value_of(const std::string& text, const std::string& source) {
  return Json::accept(text) ? parse_json(text, source) : Json(text);
}

std::string named(const std::string& override) { return one_line("--set " + override, 200); }

// `outer` is `inner` or above it.
bool holds(const JsonPointer& outer, const JsonPointer& inner) {
  const std::string prefix = outer.to_string(), text = inner.to_string();
  if (prefix.empty()) return false;  // the whole document
  return text.starts_with(prefix) && (text.size() == prefix.size() || text[prefix.size()] == '/');
}

}  // namespace

Document::Document(Json root, std::string source, std::span<const std::string> overrides, std::string_view schema)
    : root_(std::move(root)), source_(std::move(source)) {
  for (const std::string& text : overrides) apply(text);
  if (const auto violation = validate(root_, schema)) refuse(violation->key, violation->reason);
}

void Document::apply(const std::string& text) {
  const std::string blamed = named(text);
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw ConfigError(blamed + ": needs KEY=VALUE");

  const std::vector<std::string> parts = split(text.substr(0, equals));
  if (parts.size() > kMaxJsonDepth)
    throw ConfigError(blamed + ": nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");

  Json* place = &root_;
  JsonPointer key;
  for (const std::string& part : parts) {
    if (place->is_null()) *place = Json::object();
    if (!place->is_object()) throw ConfigError(blamed + ": " + one_line(key.to_string(), 200) + ": is not an object");
    place = &(*place)[part];
    key.push_back(part);
  }
  *place = value_of(text.substr(equals + 1), blamed);
  overrides_.push_back({text, key});
}

const Json* Document::find(const std::string& key) const {
  const JsonPointer pointer(key);
  if (!root_.contains(pointer)) return nullptr;
  const Json& value = root_.at(pointer);
  return value.is_null() ? nullptr : &value;
}

void Document::refuse(const JsonPointer& key, const std::string& reason) const {
  std::string blamed = source_;
  for (const Override& override : overrides_) {
    // Above its key, too: it made the objects on the way there.
    if (holds(override.key, key) || holds(key, override.key)) blamed = named(override.text);
  }
  const std::string place = key.empty() ? "" : one_line(key.to_string(), 200) + ": ";
  throw ConfigError(blamed + ": " + place + reason);
}

}  // namespace tissued::config
