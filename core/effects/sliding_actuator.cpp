#include "core/effects/sliding_actuator.hpp"

#include <array>
#include <cmath>

#include "core/effects/facet_springs.hpp"
#include "core/effects/wording.hpp"
#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

constexpr int kSlip = 0, kAcross = 1;  // of the numbers

struct PadFacets {
  std::vector<Facet> facets;
  std::vector<int> pads;
};

PadFacets facets_of(const Scene& scene, const FemMesh& mesh) {
  PadFacets out;
  for (std::size_t p = 0; p < scene.pads.size(); ++p) {
    for (const Triangle& triangle : surface_of(scene.mesh, scene.pads[p].surface, "a pad").triangles) {
      out.facets.push_back(make_facet(mesh, triangle));
      out.pads.push_back(static_cast<int>(p));
    }
  }
  return out;
}

class PadSprings final : public FacetSprings {
 public:
  PadSprings(const Effect& effect, const Scene& scene, const FemMesh& mesh, const PadFacets& pads)
      : FacetSprings(effect, scene, mesh, pads.facets, pads.pads), normals_(scene.pads.size(), Vec3::Zero()) {
    for (std::size_t e = 0; e < pads.facets.size(); ++e)
      normals_[pads.pads[e]] += pads.facets[e].area * pads.facets[e].normal;
    for (Vec3& normal : normals_) normal.normalize();
    for (const Pad& pad : scene.pads) directions_.push_back(pad.direction);
    changed();
  }
  std::string_view name() const override { return "sliding-actuator"; }

 private:
  Mat3 stiffness(const Facet& facet, int pad, const Vec3&) const override {
    const int choice = static_cast<int>(std::lround(number(kAcross)));
    const Vec3& across = choice == 0 ? normals_[pad] : choice == 1 ? directions_[pad] : facet.normal;
    return plate_springs(across, kFirm, loosened(number(kSlip)));
  }

  std::vector<Vec3> normals_, directions_;  // (pads)
};

class SlidingActuator final : public Effect {
 public:
  std::string_view kind() const override { return "sliding-actuator"; }
  std::string_view title() const override { return "The pads slide on the skin"; }
  std::string sentence(std::span<const double> values) const override {
    return values[kSlip] > 0.9 ? "The pads press on the skin but slide along it almost freely."
                               : "The pads press on the skin but give way along it.";
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 2> kParameters{
        {{"slip", "1", 0.0, 1.0, 0.0, 0.4}, {"across", "1", 0.0, 2.0, 0.0, 1.0, false, true}}};
    return kParameters;
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    return {{"slip", "1", values[kSlip]}};
  }
  std::vector<std::vector<double>> starts(const Scene&) const override { return {{0.8, 0.0}}; }
  void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const override {
    physics.terms.push_back(std::make_unique<PadSprings>(*this, scene, mesh, facets_of(scene, mesh)));
    physics.pads_hold = false;
  }
};

}  // namespace

const Effect& sliding_actuator_effect() {
  static const SlidingActuator kEffect;
  return kEffect;
}

}  // namespace tissued::core
