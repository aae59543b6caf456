#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/json_reader.hpp"

namespace tissued::config {

// A JSON document that has passed its schema, and whom to blame for each of its values.
class Document {
 public:
  // overrides: `a.b=VALUE` sets /a/b before anything is checked. `schema` is the text of a JSON Schema.
  // Throws ConfigError.
  Document(Json root, std::string source, std::span<const std::string> overrides, std::string_view schema);

  const Json& root() const { return root_; }
  const std::string& source() const { return source_; }

  // nullptr where the key is absent or null.
  const Json* find(const std::string& key) const;

  template <typename T>
  T value(const std::string& key, T fallback) const {
    const Json* found = find(key);
    return found ? found->get<T>() : fallback;
  }

  // Throws ConfigError: `FILE: KEY: REASON`, with the override in place of the file where it set the key.
  [[noreturn]] void refuse(const JsonPointer& key, const std::string& reason) const;

 private:
  struct Override {
    std::string text;  // KEY=VALUE
    JsonPointer key;
  };

  void apply(const std::string& text);

  Json root_;
  std::string source_;
  std::vector<Override> overrides_;
};

}  // namespace tissued::config
