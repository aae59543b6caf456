#include "core/effects/wording.hpp"

#include <algorithm>

namespace tissued::core {

std::string without_negative_zero(std::string text) {
  constexpr const char* kDigits = "0123456789.";
  for (std::size_t minus = text.find('-'); minus != std::string::npos; minus = text.find('-', minus + 1)) {
    const std::size_t end = std::min(text.find_first_not_of(kDigits, minus + 1), text.size());
    const std::string number = text.substr(minus + 1, end - minus - 1);
    if (!number.empty() && number.find_first_not_of("0.") == std::string::npos) text.erase(minus, 1);
  }
  return text;
}

}  // namespace tissued::core
