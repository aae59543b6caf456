#include "core/effects/softening.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/isochoric_invariant.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr int kInverseR = 0, kEnergy = 1, kModuli = 2;  // of the numbers

// Adds (eta - 1) times the isochoric stress. Remembers the largest (I1bar - 3) / 2.
class Weakening final : public WithNumbers<FemLaw> {
 public:
  using WithNumbers::WithNumbers;
  std::string_view name() const override { return "softening"; }
  int history_per_point() const override { return 1; }

  void add(const PointBatch& batch, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override {
    const double inverse_r = number(kInverseR), w0 = number(kEnergy), mu = shear_modulus(kModuli);
    if (inverse_r == 0.0) return;
    IsochoricInvariant shape;
    isochoric_invariant(deformation, Mat3::Identity(), shape);
    alignas(64) double first[kPointLanes], second[kPointLanes];
    for (int l = 0; l < kPointLanes; ++l) {
      // Beyond the largest so far nothing is lost: z = 0.
      const double z = std::max(0.0, mu * (batch.history[l] - 0.5 * (shape.value[l] - 3.0)) / w0);
      const double bell = std::exp(-z * z) * std::numbers::inv_sqrtpi, lost = std::erf(z);
      first[l] = -0.5 * mu * inverse_r * lost;
      second[l] = z > 0.0 ? 0.5 * mu * mu / w0 * inverse_r * bell : 0.0;
      response.energy[l] += inverse_r * w0 * (z * lost + bell - std::numbers::inv_sqrtpi);
    }
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kPointLanes; ++l) response.stress[k][l] += first[l] * shape.slope[k][l];
    if (tangent) add_isochoric_tangent(shape, Mat3::Identity(), first, second, response);
  }

  void accept(const PointBatch& batch, const PointDeformation& deformation, double* history) const override {
    IsochoricInvariant shape;
    isochoric_invariant(deformation, Mat3::Identity(), shape);
    for (int l = 0; l < kPointLanes; ++l) history[l] = std::max(batch.history[l], 0.5 * (shape.value[l] - 3.0));
  }
};

class Softening final : public Effect {
 public:
  std::string_view kind() const override { return "softening"; }
  std::string_view title() const override { return "The tissue is weaker after it was strained once"; }
  std::string sentence(std::span<const double> values) const override {
    return worded(
        "Where it was strained before, the tissue loses up to %.0f %% of its stiffness until it is strained "
        "further (r = %.2f, w0 = %.3g kPa).",
        100.0 * values[kInverseR], reported(values)[0].value, values[kEnergy]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 2> kParameters{
        {{"inverse_r", "1", 0.0, 1.0, 0.0, 0.4}, {"w0", "kPa", 1e-4, 1e3, 0.1, 1.0, true}}};
    return kParameters;
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    return {{"r", "1", 1.0 / std::max(values[kInverseR], 1e-6)}, {"w0", "kPa", values[kEnergy]}};
  }
  std::vector<std::vector<double>> starts(const Scene&) const override { return {{0.3, 0.02}, {0.3, 0.1}, {0.3, 0.5}}; }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.laws.push_back(std::make_unique<Weakening>(*this, scene, moduli_of(scene)));
  }
  bool has_history() const override { return true; }
};

}  // namespace

const Effect& softening_effect() {
  static const Softening kEffect;
  return kEffect;
}

}  // namespace tissued::core
