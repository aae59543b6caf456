#pragma once

#include <optional>
#include <string_view>

#include "config/violation.hpp"

namespace tissued::config {

// Whether `document` fits a JSON Schema (draft-07): nothing where it does, else the first place where it does not.
std::optional<Violation> validate(const Json& document, std::string_view schema_text);

}  // namespace tissued::config
