#include "protocol/trial.hpp"

#include <algorithm>

namespace tissued::protocol {

namespace {

std::optional<std::size_t> index_in(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return found - names.begin();
}

}  // namespace

std::optional<std::size_t> Trial::find_label(std::string_view name) const {
  if (const auto index = index_in(labels, name)) return index;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (full_label(i) == name) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> Trial::find_device(std::string_view name) const { return index_in(devices, name); }

std::string Trial::full_label(std::size_t label) const {
  return subjects[label].empty() ? labels[label] : subjects[label] + ":" + labels[label];
}

void Trial::add_label(std::string_view full) {
  const std::size_t colon = full.find(':');
  const bool split = colon != std::string_view::npos && colon > 0;
  subjects.emplace_back(split ? full.substr(0, colon) : std::string_view{});
  labels.emplace_back(split ? full.substr(colon + 1) : full);
}

std::optional<double> millimetres_per(std::string_view unit) {
  if (unit == "mm") return 1.0;
  if (unit == "cm") return 10.0;
  if (unit == "m") return 1000.0;
  return std::nullopt;
}

}  // namespace tissued::protocol
