#include "config/json_reader.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <vector>

#include "config/config_error.hpp"

namespace tissued::config {
namespace {

// The parser's words without what it puts before them: "[json.exception.parse_error.101] parse error at line 1, ...: ".
std::string reason_of(const std::string& message) {
  std::string reason = message.substr(std::min(message.find("] ") + 2, message.size()));
  if (reason.rfind("parse error at", 0) == 0) reason = reason.substr(reason.find(": ") + 2);
  return one_line(reason, 200);
}

std::string line_and_column(std::string_view text, std::size_t position) {
  const std::string_view before = text.substr(0, std::min(position > 0 ? position - 1 : 0, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const auto line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - line_start + 1);
}

// Builds the value and stops at the first thing that is refused; refusal() says what it was.
class StrictBuilder final : public nlohmann::json_sax<Json> {
 public:
  explicit StrictBuilder(std::string_view text) : text_(text) {}

  const std::string& refusal() const { return refusal_; }
  Json take() { return std::move(root_); }

  bool null() override { return take_value(Json(nullptr)); }
  bool boolean(bool value) override { return take_value(Json(value)); }
  bool number_integer(number_integer_t value) override { return take_value(Json(value)); }
  bool number_unsigned(number_unsigned_t value) override { return take_value(Json(value)); }
  bool number_float(number_float_t value, const string_t&) override { return take_value(Json(value)); }
  bool binary(binary_t&) override { return refuse("binary values are not JSON"); }

  bool string(string_t& value) override {
    if (value.size() > kMaxJsonString) return refuse(too_long(value));
    // The schema's lengths would be measured up to it only.
    if (value.find('\0') != std::string::npos) return refuse("a string holds the character U+0000");
    return take_value(Json(std::move(value)));
  }

  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    if (name.size() > kMaxJsonString) return refuse(too_long(name));
    open_.back().key = name;
    if (!open_.back().keys.insert(name).second) return refuse("given twice");
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    refusal_ = line_and_column(text_, position) + ": " + reason_of(error.what());
    return false;
  }

 private:
  struct Open {
    Json* value;
    std::string key;             // of an object: the member being read
    std::set<std::string> keys;  // of an object: those read so far
  };

  bool take_value(Json value) {
    add(std::move(value));
    return true;
  }

  Json* add(Json value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    Json& parent = *open_.back().value;
    if (parent.is_array()) {
      parent.push_back(std::move(value));
      return &parent.back();
    }
    // Straight into the vector behind it: operator[] would search all members for each new one.
    auto& members = parent.get_ref<Json::object_t&>();
    members.emplace_back(open_.back().key, std::move(value));
    return &members.back().second;
  }

  bool open(Json value) {
    if (open_.size() == kMaxJsonDepth) return refuse("nested deeper than " + std::to_string(kMaxJsonDepth) + " levels");
    open_.push_back({add(std::move(value)), {}, {}});
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  bool refuse(const std::string& reason) {
    JsonPointer place;
    for (const Open& level : open_) {
      // An array holds the element that is open in it already, but not the one that is refused.
      const std::size_t index = level.value->size() - (&level == &open_.back() ? 0 : 1);
      place.push_back(level.value->is_array() ? std::to_string(index) : level.key);
    }
    refusal_ = one_line(place.to_string(), 200) + ": " + reason;
    return false;
  }

  static std::string too_long(const std::string& text) {
    return "a string of " + std::to_string(text.size()) + " bytes is longer than the maximum " +
           std::to_string(kMaxJsonString);
  }

  std::string_view text_;
  Json root_;
  std::vector<Open> open_;
  std::string refusal_;
};

}  // namespace

Json parse_json(std::string_view text, const std::string& source) {
  if (text.size() > kMaxJsonBytes) {
    throw ConfigError(source + ": larger than the maximum of " + std::to_string(kMaxJsonBytes) + " bytes");
  }
  StrictBuilder builder(text);
  if (!Json::sax_parse(text.begin(), text.end(), &builder)) throw ConfigError(source + ": " + builder.refusal());
  return builder.take();
}

Json read_json(const std::filesystem::path& path) {
  const std::string source = path.string();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw ConfigError(source + ": no such file");
  if (!std::filesystem::is_regular_file(status)) throw ConfigError(source + ": not a regular file");
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxJsonBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad() || !file.is_open()) throw ConfigError(source + ": cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_json(text, source);
}

std::string one_line(std::string text, std::size_t max_bytes) {
  if (text.size() > max_bytes) text.replace(max_bytes, std::string::npos, "...");
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < 0x20 || c > 0x7E; }, '?');
  return text;
}

std::string quoted(const Json& value) {
  return one_line(value.dump(-1, ' ', false, Json::error_handler_t::replace), 60);
}

}  // namespace tissued::config
