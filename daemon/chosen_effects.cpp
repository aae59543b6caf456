#include "daemon/chosen_effects.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <set>

#include "daemon/ctl_options.hpp"

namespace tissued::daemon {
namespace {

bool begins_with_kind(const std::string& setting, std::string_view kind) {
  return setting.starts_with(std::string(kind) + ".");
}

std::string bounds(const core::EffectParameter& parameter) {
  char text[100];
  std::snprintf(text, sizeof text, "%g to %g%s%s", parameter.lowest, parameter.highest,
                parameter.unit == "1" ? "" : " ", parameter.unit == "1" ? "" : parameter.unit.c_str());
  return text;
}

// The parameter that `kind.name=value` sets, and to what.
std::pair<std::size_t, double> parse_setting(const core::Effect& effect, const std::string& setting) {
  const std::size_t equals = setting.find('='), begin = effect.kind().size() + 1;
  const std::string key = setting.substr(0, equals), name = key.substr(std::min(begin, key.size()));
  const auto parameters = effect.parameters();
  const auto found = std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.name == name; });
  if (found == parameters.end()) {
    std::vector<std::string> known;
    for (const core::EffectParameter& parameter : parameters) known.push_back(parameter.name);
    throw UsageError("--set " + key + ": " + std::string(effect.kind()) + " has no such number; it has " +
                     join_or(known));
  }
  double value = 0.0;
  const char* text = equals == std::string::npos ? "" : setting.c_str() + equals + 1;
  const char* end = setting.c_str() + setting.size();
  const auto [stop, error] = std::from_chars(text, end, value);
  if (equals == std::string::npos || error != std::errc{} || stop != end)
    throw UsageError("--set " + key + ": `" + text + "` is not a number");
  if (!(value >= found->lowest && value <= found->highest))
    throw UsageError("--set " + key + ": " + text + " is not within " + bounds(*found));
  return {static_cast<std::size_t>(found - parameters.begin()), value};
}

}  // namespace

std::vector<std::string> effect_kinds() {
  std::vector<std::string> kinds;
  for (const core::Effect* effect : core::effects()) kinds.emplace_back(effect->kind());
  return kinds;
}

std::vector<std::string> take_effect_settings(const std::vector<std::string>& kinds,
                                              std::vector<std::string>& settings) {
  std::vector<std::string> taken, left;
  for (const std::string& setting : settings) {
    const auto known = effect_kinds();
    const auto kind =
        std::find_if(known.begin(), known.end(), [&](const auto& k) { return begins_with_kind(setting, k); });
    (kind == known.end() ? left : taken).push_back(setting);
    if (kind != known.end() && std::find(kinds.begin(), kinds.end(), *kind) == kinds.end())
      throw UsageError("--set " + setting + ": give --effect " + *kind + ", too");
  }
  settings = left;
  return taken;
}

std::vector<core::EffectSetting> choose_effects(const core::Scene& scene, const std::vector<std::string>& kinds,
                                                const std::vector<std::string>& settings) {
  std::vector<core::EffectSetting> chosen;
  std::set<std::string> seen;
  for (const std::string& kind : kinds) {
    const core::Effect* effect = core::find_effect(kind);
    if (effect == nullptr) throw UsageError("--effect: there is no " + kind + "; there is " + join_or(effect_kinds()));
    if (!seen.insert(kind).second) throw UsageError("--effect: " + kind + " is given twice");
    chosen.push_back({effect, effect->neutral(scene)});
    for (const std::string& setting : settings) {
      if (!begins_with_kind(setting, kind)) continue;
      const auto [index, value] = parse_setting(*effect, setting);
      chosen.back().values[index] = value;
    }
  }
  return chosen;
}

nlohmann::json effects_json(const std::vector<core::EffectSetting>& effects) {
  nlohmann::json list = nlohmann::json::array();
  for (const core::EffectSetting& chosen : effects) {
    nlohmann::json numbers = nlohmann::json::object();
    for (std::size_t k = 0; k < chosen.values.size(); ++k)
      numbers[chosen.effect->parameters()[k].name] = chosen.values[k];
    list.push_back({{"kind", chosen.effect->kind()},
                    {"sentence", chosen.effect->sentence(chosen.values)},
                    {"parameters", numbers}});
  }
  return list;
}

}  // namespace tissued::daemon
