#include "core/effects/parameters.hpp"

#include <array>

#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

class Parameters final : public Effect {
 public:
  std::string_view kind() const override { return "parameters"; }
  std::string_view title() const override { return "The tissue's own numbers are other than assumed"; }
  std::string sentence(std::span<const double> values) const override {
    return worded(
        "The tissue has a Young's modulus of %.2f kPa, a Poisson's ratio of %.3f and a density of %.2f g/cm3.",
        values[0], values[1], values[2]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 3> kParameters{{{"youngs_modulus", "kPa", 1e-2, 1e4, 6.0, 0.4, true},
                                                             {"poissons_ratio", "1", 0.05, 0.499, 0.45, 0.03},
                                                             {"density", "g/cm3", 0.1, 10.0, 1.0, 0.1}}};
    return kParameters;
  }
  std::vector<double> neutral(const Scene& scene) const override {
    return {scene.material.youngs_modulus, scene.material.poissons_ratio, scene.material.density};
  }
  void adjust(Scene& scene, std::span<const double> values) const override {
    scene.material = {values[0], values[1], values[2]};
  }
  void add_to(const Scene&, const FemMesh&, FemPhysics& physics) const override {
    for (const EffectParameter& parameter : parameters())
      physics.other_names[model_parameter(*this, parameter)] = parameter.name;
  }
};

}  // namespace

const Effect& parameters_effect() {
  static const Parameters kEffect;
  return kEffect;
}

}  // namespace tissued::core
