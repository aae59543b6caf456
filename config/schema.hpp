// The published JSON Schemas (draft-07), built into the library: no path to find at run time.
#pragma once

#include <string_view>

namespace tissued::config {

// Of the configuration of tissued, "tissued-config/1".
std::string_view config_schema();
// Of bundle.json, "tissue-recording/1".
std::string_view bundle_schema();

}  // namespace tissued::config
