#include "core/effects/viscoelasticity.hpp"

#include <array>
#include <cmath>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/isochoric_invariant.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr int kShare = 0, kTime = 1, kModuli = 4;  // of the numbers; the second branch two further
constexpr int kBranches = 2;
// Rows and columns of the six entries of a symmetric tensor, and where entry (row, column) is.
constexpr int kRow[6] = {0, 1, 2, 0, 1, 0}, kColumn[6] = {0, 1, 2, 1, 2, 2};
constexpr int kEntry[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

using Symmetric = double[6][kPointLanes];

// S_iso for a shear modulus of 1: J^(-2/3) (1 - I1/3 C^-1).
void isochoric_stress(const IsochoricInvariant& v, double (*stress)[kPointLanes]) {
  for (int e = 0; e < 6; ++e) {
    const int a = kRow[e], b = kColumn[e];
    for (int l = 0; l < kPointLanes; ++l) {
      const double inverse = v.inverse[a][l] * v.inverse[b][l] + v.inverse[3 + a][l] * v.inverse[3 + b][l] +
                             v.inverse[6 + a][l] * v.inverse[6 + b][l];
      stress[e][l] = (a == b ? v.scale[l] : 0.0) - v.value[l] / 3.0 * inverse;
    }
  }
}

// h' = kept h + taken (S' - S).
struct Step {
  double kept, taken;
};

Step step_of(double dt, double tau) {
  const double r = dt / tau;
  return {std::exp(-r), r > 0.0 ? -std::expm1(-r) / r : 1.0};
}

// Adds sum_i g_i (h_i - S_iso) to the stress. Remembers S_iso, h1, h2 for a shear modulus of 1, (3 x 6 x lanes).
class RelaxingStress final : public WithNumbers<FemLaw> {
 public:
  using WithNumbers::WithNumbers;
  std::string_view name() const override { return "viscoelasticity"; }
  int history_per_point() const override { return 6 * (1 + kBranches); }

  void add(const PointBatch& batch, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override {
    if (number(kShare) == 0.0 && number(kShare + 2) == 0.0) return;
    // g_i (h_i' - S') summed is past + now S', and what is linear in S' has the energy of S_iso.
    alignas(64) Symmetric past = {};
    double now = 0.0;
    const double mu = shear_modulus(kModuli);
    for (int i = 0; i < kBranches; ++i) {
      const double share = number(kShare + 2 * i);
      const Step step = step_of(batch.time_step, number(kTime + 2 * i));
      now += mu * share * (step.taken - 1.0);
      for (int k = 0; k < 6; ++k) {
        const double* before = batch.history + k * kPointLanes;
        const double* overstress = before + 6 * (1 + i) * kPointLanes;
        for (int l = 0; l < kPointLanes; ++l)
          past[k][l] += mu * share * (step.kept * overstress[l] - step.taken * before[l]);
      }
    }
    IsochoricInvariant shape;
    isochoric_invariant(deformation, Mat3::Identity(), shape);
    add_stress(deformation, shape, past, now, response);
    if (tangent) add_tangent(shape, past, now, response);
  }

  void accept(const PointBatch& batch, const PointDeformation& deformation, double* history) const override {
    alignas(64) Symmetric stress;
    IsochoricInvariant shape;
    isochoric_invariant(deformation, Mat3::Identity(), shape);
    isochoric_stress(shape, stress);
    for (int i = 0; i < kBranches; ++i) {
      const Step step = step_of(batch.time_step, number(kTime + 2 * i));
      for (int k = 0; k < 6; ++k) {
        for (int l = 0; l < kPointLanes; ++l) {
          const int at = k * kPointLanes + l, branch = at + 6 * (1 + i) * kPointLanes;
          history[branch] = step.kept * batch.history[branch] + step.taken * (stress[k][l] - batch.history[at]);
        }
      }
    }
    for (int k = 0; k < 6; ++k)
      for (int l = 0; l < kPointLanes; ++l) history[k * kPointLanes + l] = stress[k][l];
  }

 private:
  // P = F past + now P_iso, of the energy past : (C - 1) / 2 + now (I1bar - 3) / 2.
  static void add_stress(const PointDeformation& deformation, const IsochoricInvariant& shape, const Symmetric& past,
                         double now, PointResponse& response) {
    const auto& f = deformation.f;
    for (int l = 0; l < kPointLanes; ++l)
      response.energy[l] += 0.5 * now * (shape.value[l] - 3.0) - 0.5 * (past[0][l] + past[1][l] + past[2][l]);
    for (int i = 0; i < 3; ++i) {
      for (int c = 0; c < 3; ++c) {
        const double *x = past[kEntry[0][c]], *y = past[kEntry[1][c]], *z = past[kEntry[2][c]];
        for (int l = 0; l < kPointLanes; ++l) {
          const double stress = f[3 * i][l] * x[l] + f[3 * i + 1][l] * y[l] + f[3 * i + 2][l] * z[l];
          response.stress[3 * i + c][l] += stress + 0.5 * now * shape.slope[3 * i + c][l];
          response.energy[l] += 0.5 * f[3 * i + c][l] * stress;
        }
      }
    }
  }

  static void add_tangent(const IsochoricInvariant& shape, const Symmetric& past, double now, PointResponse& response) {
    alignas(64) double first[kPointLanes], second[kPointLanes] = {};
    for (int l = 0; l < kPointLanes; ++l) first[l] = 0.5 * now;
    add_isochoric_tangent(shape, Mat3::Identity(), first, second, response);
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b <= a; ++b)
          for (int l = 0; l < kPointLanes; ++l)
            response.tangent[pair_index(3 * i + a, 3 * i + b)][l] += past[kEntry[a][b]][l];
  }
};

class Viscoelasticity final : public Effect {
 public:
  std::string_view kind() const override { return "viscoelasticity"; }
  std::string_view title() const override { return "The tissue relaxes while it is held"; }
  std::string sentence(std::span<const double> values) const override {
    std::string first = worded(
        "Held still, the tissue loses %.0f %% of its stiffness against change of shape with a time constant of %.2g s",
        100.0 * values[0], values[1]);
    if (values[2] == 0.0) return first + ".";
    return first + worded(", and another %.0f %% with %.2g s.", 100.0 * values[2], values[3]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 4> kParameters{{{"g1", "1", 0.0, 0.95, 0.0, 0.3},
                                                             {"tau1", "s", 1e-3, 1e4, 0.5, 1.0, true},
                                                             {"g2", "1", 0.0, 0.95, 0.0, 0.3, false, true},
                                                             {"tau2", "s", 1e-3, 1e4, 5.0, 1.0, true, true}}};
    return kParameters;
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    std::vector<EffectNumber> numbers = Effect::reported(values);
    if (values[2] == 0.0) numbers.resize(2);
    return numbers;
  }
  std::vector<std::vector<double>> starts(const Scene&) const override {
    std::vector<std::vector<double>> starts;
    for (double tau : {0.1, 0.5, 2.5}) starts.push_back({0.2, tau, 0.0, 5.0 * tau});
    return starts;
  }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.laws.push_back(std::make_unique<RelaxingStress>(*this, scene, moduli_of(scene)));
  }
  bool has_history() const override { return true; }
};

}  // namespace

const Effect& viscoelasticity_effect() {
  static const Viscoelasticity kEffect;
  return kEffect;
}

}  // namespace tissued::core
