#include "config/violation.hpp"

#include <algorithm>
#include <regex>
#include <string_view>
#include <vector>

namespace tissued::config {
namespace {

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "number") return value.is_number();
  if (type == "integer") return value.is_number_integer();
  if (type == "boolean") return value.is_boolean();
  return type == "null" && value.is_null();
}

std::string with_article(const std::string& type) {
  if (type == "null") return type;
  return (std::string_view("aeiou").find(type.front()) != std::string_view::npos ? "an " : "a ") + type;
}

std::string listed(const std::vector<std::string>& words, const std::string& conjunction) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " " + conjunction + " " : ", ";
    text += words[i];
  }
  return text;
}

std::string plural(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

// Bytes that do not continue a UTF-8 sequence.
std::size_t count_characters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::optional<std::string> check_type(const Json& value, const Json& schema) {
  if (schema.contains("const") && value != schema["const"]) return quoted(value) + " is not " + quoted(schema["const"]);
  if (schema.contains("enum")) {
    const Json& allowed = schema["enum"];
    if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) {
      std::vector<std::string> words;
      for (const Json& item : allowed) words.push_back(quoted(item));
      return quoted(value) + " is not one of " + listed(words, "or");
    }
  }
  if (!schema.contains("type")) return std::nullopt;
  const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
  std::vector<std::string> words;
  for (const Json& type : types) {
    if (has_type(value, type.get<std::string>())) return std::nullopt;
    words.push_back(with_article(type.get<std::string>()));
  }
  return quoted(value) + " is not " + listed(words, "or");
}

std::optional<std::string> check_number(const Json& value, const Json& schema) {
  if (!value.is_number()) return std::nullopt;
  const double number = value.get<double>();
  const auto limit = [&](const char* keyword, auto breaks, const std::string& words) -> std::optional<std::string> {
    if (!schema.contains(keyword) || !breaks(schema[keyword].get<double>())) return std::nullopt;
    return quoted(value) + " " + words + " " + quoted(schema[keyword]);
  };
  if (auto reason = limit(
          "minimum", [&](double l) { return number < l; }, "is below the minimum"))
    return reason;
  if (auto reason = limit(
          "exclusiveMinimum", [&](double l) { return number <= l; }, "is not above"))
    return reason;
  if (auto reason = limit(
          "maximum", [&](double l) { return number > l; }, "is above the maximum"))
    return reason;
  return limit(
      "exclusiveMaximum", [&](double l) { return number >= l; }, "is not below");
}

// Lengths of strings, arrays and objects share their words.
std::optional<std::string> check_size(const Json& value, const Json& schema) {
  const bool is_string = value.is_string();
  if (!is_string && !value.is_array() && !value.is_object()) return std::nullopt;
  const std::size_t size = is_string ? count_characters(value.get_ref<const std::string&>()) : value.size();
  const std::string noun = is_string ? "character" : value.is_array() ? "item" : "key";
  const char* min = is_string ? "minLength" : value.is_array() ? "minItems" : "minProperties";
  const char* max = is_string ? "maxLength" : value.is_array() ? "maxItems" : "maxProperties";
  const std::string has = quoted(value) + " has " + plural(size, noun);
  if (schema.contains(min) && size < schema[min].get<std::size_t>()) {
    return has + ", fewer than the minimum " + quoted(schema[min]);
  }
  if (schema.contains(max) && size > schema[max].get<std::size_t>()) {
    return has + ", more than the maximum " + quoted(schema[max]);
  }
  if (is_string && schema.contains("pattern")) {
    const std::string& text = value.get_ref<const std::string&>();
    if (!std::regex_search(text, std::regex(schema["pattern"].get<std::string>()))) {
      return quoted(value) + " does not match " + schema["pattern"].get<std::string>();
    }
  }
  return std::nullopt;
}

class Search {
 public:
  explicit Search(const Json& root) : root_(root) {}

  std::optional<Violation> visit(const Json& value, const Json& node, const JsonPointer& key) const {
    const Json& schema = resolve(node);
    if (auto reason = check_type(value, schema)) return Violation{key, *reason};
    if (auto reason = check_number(value, schema)) return Violation{key, *reason};
    if (auto reason = check_size(value, schema)) return Violation{key, *reason};
    if (value.is_array()) return visit_array(value, schema, key);
    if (value.is_object()) return visit_object(value, schema, key);
    return std::nullopt;
  }

 private:
  const Json& resolve(const Json& node) const {
    if (!node.is_object() || !node.contains("$ref")) return node;
    return root_.at(JsonPointer(node["$ref"].get<std::string>().substr(1)));  // "#/definitions/..."
  }

  std::optional<Violation> visit_array(const Json& array, const Json& schema, const JsonPointer& key) const {
    for (std::size_t i = 0; i < array.size(); ++i) {
      if (schema.contains("items")) {
        if (auto violation = visit(array[i], schema["items"], key / i)) return violation;
      }
      const auto end = array.begin() + static_cast<std::ptrdiff_t>(i);
      if (schema.value("uniqueItems", false) && std::find(array.begin(), end, array[i]) != end) {
        return Violation{key / i, quoted(array[i]) + " is given twice"};
      }
    }
    return std::nullopt;
  }

  std::optional<Violation> visit_object(const Json& object, const Json& schema, const JsonPointer& key) const {
    for (const auto& [name, value] : object.items()) {
      if (schema.contains("propertyNames")) {
        if (auto violation = visit(Json(name), schema["propertyNames"], key / name)) return violation;
      }
      if (schema.contains("properties") && schema["properties"].contains(name)) {
        if (auto violation = visit(value, schema["properties"][name], key / name)) return violation;
      } else if (schema.contains("additionalProperties")) {
        const Json& others = schema["additionalProperties"];
        if (others == false) return Violation{key / name, "unknown key; known are " + known_keys(schema)};
        if (auto violation = visit(value, others, key / name)) return violation;
      }
    }
    return find_missing(object, schema, key);
  }

  static std::optional<Violation> find_missing(const Json& object, const Json& schema, const JsonPointer& key) {
    if (!schema.contains("required")) return std::nullopt;
    for (const Json& name : schema["required"]) {
      if (!object.contains(name.get<std::string>())) return Violation{key / name.get<std::string>(), "is missing"};
    }
    return std::nullopt;
  }

  static std::string known_keys(const Json& schema) {
    std::vector<std::string> names;
    for (const auto& [name, ignored] : schema["properties"].items()) names.push_back(name);
    return listed(names, "and");
  }

  const Json& root_;
};

}  // namespace

std::optional<Violation> find_violation(const Json& document, const Json& schema) {
  return Search(schema).visit(document, schema, JsonPointer());
}

}  // namespace tissued::config
