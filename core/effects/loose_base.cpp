#include "core/effects/loose_base.hpp"

#include <array>

#include "core/effects/facet_springs.hpp"
#include "core/effects/smooth_edge.hpp"
#include "core/effects/spread_places.hpp"
#include "core/effects/wording.hpp"
#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

constexpr int kCenter = 0, kRadius = 3, kLooseness = 4, kNormalHeld = 5;  // of the numbers
constexpr double kLeft = 1e-5;  // kPa/mm that are left where nothing holds, so that a body on nothing is still solvable

const SurfaceGroup& base_of(const Scene& scene) { return surface_of(scene.mesh, scene.fixed_surface, "the support"); }

std::vector<Facet> facets_of(const Scene& scene, const FemMesh& mesh) {
  std::vector<Facet> facets;
  for (const Triangle& triangle : base_of(scene).triangles) facets.push_back(make_facet(mesh, triangle));
  return facets;
}

class BaseSprings final : public FacetSprings {
 public:
  BaseSprings(const Effect& effect, const Scene& scene, const FemMesh& mesh)
      : FacetSprings(effect, scene, mesh, facets_of(scene, mesh),
                     std::vector<int>(base_of(scene).triangles.size(), -1)) {
    changed();
  }
  std::string_view name() const override { return "loose-base"; }

 private:
  Mat3 stiffness(const Facet& facet, int, const Vec3& rest) const override {
    const double inside = smooth_inside((rest - vector(kCenter)).norm(), number(kRadius));
    const double loose = kLeft + loosened(number(kLooseness) * inside);
    return plate_springs(facet.normal, number(kNormalHeld) > 0.5 ? kFirm : loose, loose);
  }
};

class LooseBase final : public Effect {
 public:
  std::string_view kind() const override { return "loose-base"; }
  std::string_view title() const override { return "A part of the support does not hold the tissue"; }
  std::string sentence(std::span<const double> values) const override {
    return worded("Within %.0f mm around (%.0f, %.0f, %.0f) mm the tissue %s on its support%s.", values[kRadius],
                  values[0], values[1], values[2], values[kLooseness] > 0.9 ? "is loose" : "gives way",
                  values[kNormalHeld] > 0.5 ? ", along it" : "");
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 6> kParameters{{{"center.x", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"center.y", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"center.z", "mm", -1e4, 1e4, 0.0, 10.0, false, true},
                                                             {"radius", "mm", 2.0, 200.0, 12.0, 0.5, true},
                                                             {"looseness", "1", 0.0, 1.0, 0.0, 0.4, false, true},
                                                             {"normal_held", "1", 0.0, 1.0, 1.0, 1.0, false, true}}};
    return kParameters;
  }
  std::vector<double> neutral(const Scene& scene) const override {
    std::vector<double> values = Effect::neutral(scene);
    const std::vector<int> nodes = nodes_of(base_of(scene));
    Eigen::Map<Vec3> center(values.data());
    for (int node : nodes) center += scene.mesh.node(node) / static_cast<double>(nodes.size());
    return values;
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    std::vector<EffectNumber> numbers = Effect::reported(values);
    numbers.resize(4);  // where, how far
    return numbers;
  }
  std::vector<int> amplitudes() const override { return {}; }
  std::vector<std::vector<double>> starts(const Scene& scene) const override {
    constexpr std::size_t kPlaces = 12;
    constexpr double kShareOfBase = 0.35;
    std::vector<Vec3> nodes;
    for (int node : nodes_of(base_of(scene))) nodes.push_back(scene.mesh.node(node));
    double reach = 0.0;
    for (const Vec3& node : nodes) reach = std::max(reach, 0.5 * (node - nodes.front()).norm());
    std::vector<std::vector<double>> starts;
    for (const Vec3& place : spread_places(nodes, kPlaces))
      starts.push_back({place.x(), place.y(), place.z(), kShareOfBase * reach, 1.0, 1.0});
    return starts;
  }
  void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const override {
    physics.terms.push_back(std::make_unique<BaseSprings>(*this, scene, mesh));
    physics.fixed_nodes.clear();
  }
};

}  // namespace

const Effect& loose_base_effect() {
  static const LooseBase kEffect;
  return kEffect;
}

}  // namespace tissued::core
