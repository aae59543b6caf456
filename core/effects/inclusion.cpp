#include "core/effects/inclusion.hpp"

#include <array>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/smooth_edge.hpp"
#include "core/effects/spread_places.hpp"
#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr int kCenter = 0, kRadius = 3, kRatio = 4;  // of the numbers

class Lump final : public WithNumbers<FemField> {
 public:
  Lump(const Effect& effect, const Scene& scene) : WithNumbers(effect, scene) { changed(); }
  double log_factor(const Vec3& rest) const override {
    return log_ratio_ == 0.0 ? 0.0 : log_ratio_ * smooth_inside((rest - vector(kCenter)).norm(), radius_);
  }

 private:
  void changed() override {
    log_ratio_ = std::log(number(kRatio));
    radius_ = smooth_ball_radius(number(kRadius));
  }
  double log_ratio_ = 0.0, radius_ = 0.0;
};

class Inclusion final : public Effect {
 public:
  std::string_view kind() const override { return "inclusion"; }
  std::string_view title() const override { return "There is a lump of other stiffness in the tissue"; }
  std::string sentence(std::span<const double> values) const override {
    const double ratio = values[kRatio];
    return worded("A lump of %.0f mm radius around (%.0f, %.0f, %.0f) mm is %.1f times as %s as the tissue around it.",
                  values[kRadius], values[0], values[1], values[2], ratio < 1.0 ? 1.0 / ratio : ratio,
                  ratio < 1.0 ? "soft" : "stiff");
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 5> kParameters{{{"center.x", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"center.y", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"center.z", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"radius", "mm", 3.0, 80.0, 10.0, 0.5, true},
                                                             {"ratio", "1", 0.02, 50.0, 1.0, 1.0, true}}};
    return kParameters;
  }
  std::vector<double> neutral(const Scene& scene) const override {
    const Vec3 middle = scene.mesh.rest.colwise().mean().transpose();
    return {middle.x(), middle.y(), middle.z(), parameters()[kRadius].neutral, parameters()[kRatio].neutral};
  }
  std::vector<int> amplitudes() const override { return {kRatio}; }
  std::vector<std::vector<double>> starts(const Scene& scene) const override {
    constexpr std::size_t kPlaces = 40;
    constexpr double kShareOfReach = 0.18, kRatioToBeginWith = 1.5;
    std::vector<Vec3> middles;
    for (const Tet& tet : scene.mesh.tets)
      middles.push_back(0.25 * (scene.mesh.node(tet[0]) + scene.mesh.node(tet[1]) + scene.mesh.node(tet[2]) +
                                scene.mesh.node(tet[3])));
    const Eigen::RowVector3d size = scene.mesh.rest.colwise().maxCoeff() - scene.mesh.rest.colwise().minCoeff();
    std::vector<std::vector<double>> starts;
    for (const Vec3& place : spread_places(middles, kPlaces))
      starts.push_back({place.x(), place.y(), place.z(), kShareOfReach * 0.5 * size.maxCoeff(), kRatioToBeginWith});
    return starts;
  }
  void add_to(const Scene& scene, const FemMesh&, FemPhysics& physics) const override {
    physics.fields.push_back(std::make_unique<Lump>(*this, scene));
  }
};

}  // namespace

const Effect& inclusion_effect() {
  static const Inclusion kEffect;
  return kEffect;
}

}  // namespace tissued::core
