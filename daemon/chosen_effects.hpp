#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/effects/effect.hpp"

namespace tissued::daemon {

/// The kinds that --effect knows.
std::vector<std::string> effect_kinds();

/// Takes out of `settings` (KEY=VALUE) those that begin with one of the kinds and a point, e.g. viscoelasticity.g1=0.4:
/// they are not the bundle's. Throws UsageError for a kind that is not among `kinds`.
std::vector<std::string> take_effect_settings(const std::vector<std::string>& kinds,
                                              std::vector<std::string>& settings);

/// At what is neutral in the scene but for the settings. Throws UsageError: no such kind or number, given twice, out of
/// its bounds.
std::vector<core::EffectSetting> choose_effects(const core::Scene& scene, const std::vector<std::string>& kinds,
                                                const std::vector<std::string>& settings);

/// Kind, sentence and numbers of each.
nlohmann::json effects_json(const std::vector<core::EffectSetting>& effects);

}  // namespace tissued::daemon
