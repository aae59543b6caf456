// Sentences with numbers in them.
#pragma once

#include <cstdio>
#include <string>

namespace tissued::core {

// format: as printf's; at most 300 characters come of it.
template <typename... Numbers>
std::string worded(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

}  // namespace tissued::core
