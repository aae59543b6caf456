#include "core/effects/strain_stiffening.hpp"

#include <array>
#include <cmath>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/isochoric_invariant.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr int kB = 0, kModuli = 1;  // of the numbers

// (e^x - 1 - x) / x, without loss near 0.
double excess(double x) {
  return std::abs(x) < 1e-3 ? x * (0.5 + x * (1.0 / 6.0 + x / 24.0)) : std::expm1(x) / x - 1.0;
}

// Adds mu/(2b) (exp(b (I1bar - 3)) - 1) - mu/2 (I1bar - 3).
class Stiffening final : public WithNumbers<FemLaw> {
 public:
  using WithNumbers::WithNumbers;
  std::string_view name() const override { return "strain-stiffening"; }

  void add(const PointBatch&, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override {
    const double b = number(kB), half = 0.5 * shear_modulus(kModuli);
    if (b == 0.0) return;
    IsochoricInvariant shape;
    isochoric_invariant(deformation, Mat3::Identity(), shape);
    alignas(64) double first[kPointLanes], second[kPointLanes];
    for (int l = 0; l < kPointLanes; ++l) {
      const double stretch = shape.value[l] - 3.0;
      first[l] = half * std::expm1(b * stretch);
      second[l] = half * b * std::exp(b * stretch);
      response.energy[l] += half * stretch * excess(b * stretch);
    }
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kPointLanes; ++l) response.stress[k][l] += first[l] * shape.slope[k][l];
    if (tangent) add_isochoric_tangent(shape, Mat3::Identity(), first, second, response);
  }
};

class StrainStiffening final : public Effect {
 public:
  std::string_view kind() const override { return "strain-stiffening"; }
  std::string_view title() const override { return "The tissue gets stiffer the further it is stretched"; }
  std::string sentence(std::span<const double> values) const override {
    constexpr double kStretch = 1.2;  // of a bar that keeps its volume
    const double invariant = kStretch * kStretch + 2.0 / kStretch - 3.0;
    return worded("Stretched by 20 %%, the tissue is %.1f times as stiff as unstretched (b = %.2f).",
                  std::exp(values[kB] * invariant), values[kB]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 1> kParameters{{{"b", "1", 0.0, 50.0, 0.0, 2.0}}};
    return kParameters;
  }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.laws.push_back(std::make_unique<Stiffening>(*this, scene, moduli_of(scene)));
  }
};

}  // namespace

const Effect& strain_stiffening_effect() {
  static const StrainStiffening kEffect;
  return kEffect;
}

}  // namespace tissued::core
