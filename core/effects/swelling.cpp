#include "core/effects/swelling.hpp"

#include <algorithm>
#include <array>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/isochoric_invariant.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr int kRate = 0, kModuli = 1;     // of the numbers
constexpr double kSmallestGrowth = 0.05;  // Jg is held above it

// Adds kappa/2 [(J / Jg - 1)^2 - (J - 1)^2]. Remembers the time since rest.
class Growth final : public WithNumbers<FemLaw> {
 public:
  using WithNumbers::WithNumbers;
  std::string_view name() const override { return "swelling"; }
  bool on_volume() const override { return true; }
  int history_per_point() const override { return 1; }

  void add(const PointBatch& batch, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override {
    const double time = batch.history[0] + batch.time_step;
    const double inverse = 1.0 / std::max(kSmallestGrowth, 1.0 + number(kRate) * time);
    if (inverse == 1.0) return;
    const double kappa = bulk_modulus(kModuli), second = kappa * (inverse * inverse - 1.0);
    IsochoricInvariant shape;
    isochoric_invariant(deformation, Mat3::Identity(), shape);
    alignas(64) double outer[kPointLanes], turned[kPointLanes];
    for (int l = 0; l < kPointLanes; ++l) {
      const double j = shape.j[l], change = j * inverse - 1.0;
      const double first = kappa * (change * inverse - (j - 1.0));
      response.energy[l] += j > 0 ? 0.5 * kappa * (change * change - (j - 1.0) * (j - 1.0)) : 0.0;
      outer[l] = second * j * j + first * j;
      turned[l] = -first * j;
    }
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kPointLanes; ++l) response.stress[k][l] -= turned[l] * shape.inverse[k][l];
    if (tangent) add_tangent(shape, outer, turned, response);
  }

  void accept(const PointBatch& batch, const PointDeformation&, double* history) const override {
    for (int l = 0; l < kPointLanes; ++l) history[l] = batch.history[l] + batch.time_step;
  }

 private:
  static void add_tangent(const IsochoricInvariant& shape, const double* outer, const double* turned,
                          PointResponse& response) {
    for (int r = 0; r < 9; ++r) {
      for (int c = 0; c <= r; ++c) {
        const int across = 3 * (r / 3) + c % 3, down = 3 * (c / 3) + r % 3;
        for (int l = 0; l < kPointLanes; ++l)
          response.tangent[pair_index(r, c)][l] += outer[l] * shape.inverse[r][l] * shape.inverse[c][l] +
                                                   turned[l] * shape.inverse[across][l] * shape.inverse[down][l];
      }
    }
  }
};

class Swelling final : public Effect {
 public:
  std::string_view kind() const override { return "swelling"; }
  std::string_view title() const override { return "The tissue changes its volume with time"; }
  std::string sentence(std::span<const double> values) const override {
    return worded("The tissue %s by %.2g %% of its volume in a minute.", values[kRate] < 0.0 ? "shrinks" : "swells",
                  6000.0 * std::abs(values[kRate]));
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 1> kParameters{{{"rate", "1/s", -0.1, 0.1, 0.0, 1e-3}}};
    return kParameters;
  }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.laws.push_back(std::make_unique<Growth>(*this, scene, moduli_of(scene)));
  }
  bool has_history() const override { return true; }
};

}  // namespace

const Effect& swelling_effect() {
  static const Swelling kEffect;
  return kEffect;
}

}  // namespace tissued::core
