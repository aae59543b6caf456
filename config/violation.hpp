#pragma once

#include <optional>
#include <string>

#include "config/json_reader.hpp"

namespace tissued::config {

// What is wrong with a document, for a person.
struct Violation {
  JsonPointer key;
  std::string reason;  // e.g. "0 is below the minimum 1"
};

// The first place, in the document's order, where `document` breaks `schema`: the keywords of draft-07 that the house's
// schemas use, `definitions` by $ref included. The verdict is valijson's (validation.hpp); this finds the words for it.
std::optional<Violation> find_violation(const Json& document, const Json& schema);

}  // namespace tissued::config
