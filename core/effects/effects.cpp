#include <array>

#include "core/effects/anisotropy.hpp"
#include "core/effects/attached_mass.hpp"
#include "core/effects/damping.hpp"
#include "core/effects/effect.hpp"
#include "core/effects/gravity.hpp"
#include "core/effects/inclusion.hpp"
#include "core/effects/loose_base.hpp"
#include "core/effects/parameters.hpp"
#include "core/effects/skin.hpp"
#include "core/effects/sliding_actuator.hpp"
#include "core/effects/softening.hpp"
#include "core/effects/stiffness_gradient.hpp"
#include "core/effects/strain_stiffening.hpp"
#include "core/effects/swelling.hpp"
#include "core/effects/viscoelasticity.hpp"

namespace tissued::core {

std::span<const Effect* const> effects() {
  static const std::array kEffects{
      &parameters_effect(), &viscoelasticity_effect(),    &strain_stiffening_effect(),
      &inclusion_effect(),  &stiffness_gradient_effect(), &anisotropy_effect(),
      &skin_effect(),       &softening_effect(),          &swelling_effect(),
      &gravity_effect(),    &loose_base_effect(),         &sliding_actuator_effect(),
      &damping_effect(),    &attached_mass_effect(),
  };
  return kEffects;
}

const Effect* find_effect(std::string_view kind) {
  for (const Effect* effect : effects())
    if (effect->kind() == kind) return effect;
  return nullptr;
}

std::vector<double> Effect::neutral(const Scene&) const {
  std::vector<double> values;
  for (const EffectParameter& parameter : parameters()) values.push_back(parameter.neutral);
  return values;
}

std::vector<std::vector<double>> Effect::starts(const Scene& scene) const {
  std::vector<double> values = neutral(scene);
  values.front() += parameters().front().typical;
  return {values};
}

std::vector<EffectNumber> Effect::reported(std::span<const double> values) const {
  std::vector<EffectNumber> numbers;
  for (std::size_t k = 0; k < values.size(); ++k)
    numbers.push_back({parameters()[k].name, parameters()[k].unit, values[k]});
  return numbers;
}

FemEffect fem_effect(const Effect& effect) {
  return
      [&effect](const Scene& scene, const FemMesh& mesh, FemPhysics& physics) { effect.add_to(scene, mesh, physics); };
}

Scene adjusted(const Scene& scene, std::span<const EffectSetting> settings) {
  Scene out = scene;
  for (const EffectSetting& setting : settings) setting.effect->adjust(out, setting.values);
  return out;
}

std::string model_parameter(const Effect& effect, const EffectParameter& parameter) {
  return std::string(effect.kind()) + "." + parameter.name;
}

void set_effect(FemModel& model, const Effect& effect, std::span<const double> values) {
  for (std::size_t k = 0; k < values.size(); ++k)
    model.set_parameter(model_parameter(effect, effect.parameters()[k]), values[k]);
}

}  // namespace tissued::core
