#include "config/validation.hpp"

#include <map>
#include <mutex>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

namespace tissued::config {
namespace {

using Adapter = valijson::adapters::NlohmannJsonAdapter;

struct Schema {
  Json text;
  valijson::Schema compiled;

  explicit Schema(std::string_view source) : text(Json::parse(source)) {
    const nlohmann::json unordered = text;  // valijson's adapter knows this kind only
    valijson::SchemaParser().populateSchema(Adapter(unordered), compiled);
  }
};

// Of what is compiled, and while anything is validated: patterns are std::regex, and libstdc++'s fills a cache of the
// locale without a lock.
std::mutex one_at_a_time;

// Compiled once, which takes longer than most documents do.
const Schema& compiled(std::string_view source) {
  static std::map<std::string, Schema, std::less<>> known;
  const auto found = known.find(source);
  return found != known.end() ? found->second : known.try_emplace(std::string(source), source).first->second;
}

}  // namespace

std::optional<Violation> validate(const Json& document, std::string_view schema_text) {
  const std::lock_guard lock(one_at_a_time);
  const Schema& schema = compiled(schema_text);
  const nlohmann::json unordered = document;
  if (valijson::Validator().validate(schema.compiled, Adapter(unordered), nullptr)) return std::nullopt;
  if (auto violation = find_violation(document, schema.text)) return violation;
  return Violation{JsonPointer(), "does not fit the schema"};
}

}  // namespace tissued::config
