#include "core/effects/damping.hpp"

#include <array>
#include <numbers>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

class Rates final : public WithNumbers<FemDamping> {
 public:
  using WithNumbers::WithNumbers;
  RayleighDamping rates() const override { return {number(0), number(1)}; }
};

class Damping final : public Effect {
 public:
  std::string_view kind() const override { return "damping"; }
  std::string_view title() const override { return "The tissue's motion dies down faster than assumed"; }
  std::string sentence(std::span<const double> values) const override {
    const double omega = 2.0 * std::numbers::pi * 5.0;  // of 5 Hz, where soft tissue swings
    return worded("Swinging at 5 Hz, the tissue is damped by %.1f %% of critical (alpha = %.3g 1/s, beta = %.3g s).",
                  50.0 * (values[0] / omega + values[1] * omega), values[0], values[1]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 2> kParameters{
        {{"alpha", "1/s", 0.0, 1e3, 0.0, 5.0}, {"beta", "s", 0.0, 10.0, 0.0, 5e-3}}};
    return kParameters;
  }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.dampings.push_back(std::make_unique<Rates>(*this, scene));
  }
  bool is_dynamic() const override { return true; }
};

}  // namespace

const Effect& damping_effect() {
  static const Damping kEffect;
  return kEffect;
}

}  // namespace tissued::core
