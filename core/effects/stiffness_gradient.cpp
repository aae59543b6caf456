#include "core/effects/stiffness_gradient.hpp"

#include <array>
#include <cmath>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

class Slope final : public WithNumbers<FemField> {
 public:
  using WithNumbers::WithNumbers;
  double log_factor(const Vec3& rest) const override { return vector(0).dot(rest); }
};

class StiffnessGradient final : public Effect {
 public:
  std::string_view kind() const override { return "stiffness-gradient"; }
  std::string_view title() const override { return "The tissue's stiffness varies from one side to the other"; }
  std::string sentence(std::span<const double> values) const override {
    const Vec3 slope(values[0], values[1], values[2]), axis = slope.normalized();
    return worded("Every 10 mm along (%.2f, %.2f, %.2f) the tissue gets %.0f %% stiffer.", axis.x(), axis.y(), axis.z(),
                  100.0 * std::expm1(10.0 * slope.norm()));
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 3> kParameters{{{"slope.x", "1/mm", -0.3, 0.3, 0.0, 0.02},
                                                             {"slope.y", "1/mm", -0.3, 0.3, 0.0, 0.02},
                                                             {"slope.z", "1/mm", -0.3, 0.3, 0.0, 0.02}}};
    return kParameters;
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    const Vec3 slope(values[0], values[1], values[2]);
    const Vec3 axis = slope.norm() > 0.0 ? slope.normalized() : Vec3::UnitZ();
    return {
        {"k", "1/mm", slope.norm()}, {"axis.x", "1", axis.x()}, {"axis.y", "1", axis.y()}, {"axis.z", "1", axis.z()}};
  }
  std::vector<int> amplitudes() const override { return {0, 1, 2}; }
  std::vector<std::vector<double>> starts(const Scene& scene) const override { return {neutral(scene)}; }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.fields.push_back(std::make_unique<Slope>(*this, scene));
  }
};

}  // namespace

const Effect& stiffness_gradient_effect() {
  static const StiffnessGradient kEffect;
  return kEffect;
}

}  // namespace tissued::core
