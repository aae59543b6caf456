#include "daemon/evaluated_model.hpp"

#include <algorithm>

#include "config/json_reader.hpp"
#include "core/simulator.hpp"
#include "daemon/ctl_options.hpp"

namespace tissued::daemon {
namespace {

// As printed: linear tetrahedra, one iteration and one correction per n, Q = 3 I, R = 0.01 I.
const std::vector<EvaluatedModel>& published_models() {
  static const std::vector<EvaluatedModel> kModels{
      {"paper",
       {"simulator.kind=kf-admm", "simulator.scheme=algorithm-1", "simulator.element=p1", "simulator.weight_scale=4",
        "filter.preset=paper"}},
      {"paper-admm",
       {"simulator.kind=admm", "simulator.scheme=algorithm-1", "simulator.element=p1", "simulator.weight_scale=4"}},
  };
  return kModels;
}

// Splits at the commas outside of brackets.
std::vector<std::string> split_overrides(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    if (c == '[') ++depth;
    if (c == ']') --depth;
    if (c == ',' && depth == 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

// Every value of a configuration but what it is about; lists are values.
void flatten(const config::Json& value, const std::string& key, std::vector<std::string>& overrides) {
  if (key == "format" || key == "bundle") return;
  if (!value.is_object()) {
    overrides.push_back(key + "=" + value.dump());
    return;
  }
  for (const auto& [name, inner] : value.items()) flatten(inner, key.empty() ? name : key + "." + name, overrides);
}

bool names_file(const std::string& text) { return text.ends_with(".json") && text.find('=') == std::string::npos; }

}  // namespace

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const std::string_view name : core::simulator_names()) names.emplace_back(name);
  for (const EvaluatedModel& model : published_models()) names.push_back(model.name);
  return names;
}

EvaluatedModel named_model(const std::string& name) {
  const auto published = std::ranges::find(published_models(), name, &EvaluatedModel::name);
  if (published != published_models().end()) return *published;
  if (std::ranges::count(core::simulator_names(), name) == 0) {
    throw UsageError("--models: there is no model `" + name + "`; there are " + join_or(model_names()));
  }
  return {name, {"simulator.kind=" + name}};
}

EvaluatedModel parse_variant(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos || colon == 0) {
    throw UsageError("--variant: `" + text + "` is not NAME:KEY=VALUE,... or NAME:FILE.json");
  }
  if (const std::string file = text.substr(colon + 1); names_file(file)) {
    EvaluatedModel model{text.substr(0, colon), {}};
    flatten(config::read_json(file), "", model.overrides);
    return model;
  }
  EvaluatedModel model{text.substr(0, colon), split_overrides(text.substr(colon + 1))};
  for (const std::string& override : model.overrides) {
    const std::size_t equals = override.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw UsageError("--variant " + model.name + ": `" + override + "` is not KEY=VALUE");
    }
  }
  return model;
}

}  // namespace tissued::daemon
