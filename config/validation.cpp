#include "config/validation.hpp"

#include <mutex>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

namespace tissued::config {
namespace {

bool fits(const Json& document, std::string_view schema_text) {
  using Adapter = valijson::adapters::NlohmannJsonAdapter;
  const nlohmann::json schema_json = nlohmann::json::parse(schema_text);
  const nlohmann::json unordered = document;  // valijson's adapter knows this kind only
  valijson::Schema schema;
  valijson::SchemaParser().populateSchema(Adapter(schema_json), schema);
  // Patterns are std::regex, and libstdc++'s fills a cache of the locale without a lock.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  return valijson::Validator().validate(schema, Adapter(unordered), nullptr);
}

}  // namespace

std::optional<Violation> validate(const Json& document, std::string_view schema_text) {
  if (fits(document, schema_text)) return std::nullopt;
  if (auto violation = find_violation(document, Json::parse(schema_text))) return violation;
  return Violation{JsonPointer(), "does not fit the schema"};
}

}  // namespace tissued::config
