// Sentences with numbers in them.
#pragma once

#include <cstdio>
#include <string>

namespace tissued::core {

// Takes the sign off what was rounded to -0, -0.0 and so on.
std::string without_negative_zero(std::string text);

// format: as printf's; at most 300 characters come of it.
template <typename... Numbers>
std::string worded(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  return without_negative_zero(text);
}

}  // namespace tissued::core
