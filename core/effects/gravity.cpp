#include "core/effects/gravity.hpp"

#include <array>

#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

class GravityEffect final : public Effect {
 public:
  std::string_view kind() const override { return "gravity"; }
  std::string_view title() const override { return "Weight pulls in a direction that was not assumed"; }
  std::string sentence(std::span<const double> values) const override {
    const Vec3 gravity(values[0], values[1], values[2]);
    const Vec3 along = gravity.normalized();
    return worded("The tissue's weight acts with %.2f g along (%.2f, %.2f, %.2f).", gravity.norm(), along.x(),
                  along.y(), along.z());
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 3> kParameters{{{"gravity.x", "g0", -3.0, 3.0, 0.0, 0.6},
                                                             {"gravity.y", "g0", -3.0, 3.0, 0.0, 0.6},
                                                             {"gravity.z", "g0", -3.0, 3.0, 0.0, 0.6}}};
    return kParameters;
  }
  std::vector<double> neutral(const Scene& scene) const override {
    return {scene.gravity.x(), scene.gravity.y(), scene.gravity.z()};
  }
  std::vector<int> amplitudes() const override { return {0, 1, 2}; }
  std::vector<std::vector<double>> starts(const Scene& scene) const override { return {neutral(scene)}; }
  void adjust(Scene& scene, std::span<const double> values) const override {
    scene.gravity = {values[0], values[1], values[2]};
  }
  void add_to(const Scene&, const FemMesh&, FemPhysics& physics) const override {
    physics.other_names["gravity.gravity.x"] = "gravity_x";
    physics.other_names["gravity.gravity.y"] = "gravity_y";
    physics.other_names["gravity.gravity.z"] = "gravity_z";
  }
};

}  // namespace

const Effect& gravity_effect() {
  static const GravityEffect kEffect;
  return kEffect;
}

}  // namespace tissued::core
