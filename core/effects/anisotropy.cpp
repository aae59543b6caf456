#include "core/effects/anisotropy.hpp"

#include <array>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/isochoric_invariant.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr int kStiffness = 0, kAxis = 1;  // of the numbers

Vec3 unit(const Vec3& axis) { return axis.norm() > 1e-9 ? axis.normalized() : Vec3::UnitZ(); }

class Fibres final : public WithNumbers<FemLaw> {
 public:
  using WithNumbers::WithNumbers;
  std::string_view name() const override { return "anisotropy"; }

  void add(const PointBatch&, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override {
    const double k = number(kStiffness);
    if (k == 0.0) return;
    const Vec3 axis = unit(vector(kAxis));
    const Mat3 square = axis * axis.transpose();
    IsochoricInvariant along;
    isochoric_invariant(deformation, square, along);
    alignas(64) double first[kPointLanes], second[kPointLanes];
    for (int l = 0; l < kPointLanes; ++l) {
      const double stretch = along.value[l] - 1.0;
      first[l] = k * stretch;
      second[l] = k;
      response.energy[l] += 0.5 * k * stretch * stretch;
    }
    for (int c = 0; c < 9; ++c)
      for (int l = 0; l < kPointLanes; ++l) response.stress[c][l] += first[l] * along.slope[c][l];
    if (tangent) add_isochoric_tangent(along, square, first, second, response);
  }
};

class Anisotropy final : public Effect {
 public:
  std::string_view kind() const override { return "anisotropy"; }
  std::string_view title() const override { return "The tissue is stiffer along one direction, as if it had fibres"; }
  std::string sentence(std::span<const double> values) const override {
    const Vec3 axis = unit({values[1], values[2], values[3]});
    return worded("Fibres along (%.2f, %.2f, %.2f) add %.1f kPa to the stiffness in that direction.", axis.x(),
                  axis.y(), axis.z(), 4.0 * values[kStiffness]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 4> kParameters{{{"k", "kPa", 0.0, 1e3, 0.0, 3.0},
                                                             {"axis.x", "1", -1e3, 1e3, 0.0, 0.5},
                                                             {"axis.y", "1", -1e3, 1e3, 0.0, 0.5},
                                                             {"axis.z", "1", -1e3, 1e3, 1.0, 0.5}}};
    return kParameters;
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    const Vec3 axis = unit({values[1], values[2], values[3]});
    return {{"k", "kPa", values[kStiffness]},
            {"axis.x", "1", axis.x()},
            {"axis.y", "1", axis.y()},
            {"axis.z", "1", axis.z()}};
  }
  std::vector<std::vector<double>> starts(const Scene&) const override {
    std::vector<std::vector<double>> starts;
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 0), Vec3(1, -1, 0), Vec3(1, 0, 1),
                             Vec3(1, 0, -1), Vec3(0, 1, 1), Vec3(0, 1, -1)})
      starts.push_back({1.0, axis.normalized().x(), axis.normalized().y(), axis.normalized().z()});
    return starts;
  }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.laws.push_back(std::make_unique<Fibres>(*this, scene));
  }
};

}  // namespace

const Effect& anisotropy_effect() {
  static const Anisotropy kEffect;
  return kEffect;
}

}  // namespace tissued::core
