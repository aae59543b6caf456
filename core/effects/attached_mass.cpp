#include "core/effects/attached_mass.hpp"

#include <array>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/wording.hpp"
#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

constexpr int kMass = 0, kAt = 1, kLoad = 4, kGravity = 5;  // of the numbers

// Where the mass is: a point of one element. Every element is an entity, so that it may move from one to another.
class PointLoad : public WithNumbers<FemTerm> {
 public:
  PointLoad(const Effect& effect, const Scene& scene, const FemMesh& mesh, const std::vector<BodyNumber>& followed)
      : WithNumbers(effect, scene, followed), body_(&scene.mesh), mesh_(&mesh) {
    changed();
  }
  std::string_view name() const override { return "attached-mass"; }
  int entity_count() const override { return mesh_->element_count(); }
  int nodes_per_entity() const override { return mesh_->element_nodes(); }
  std::span<const int> nodes_of_entity(int entity) const override { return mesh_->nodes_of_element(entity); }

 protected:
  // What a load is made of is for the motion of the trials that have it (core/diagnosis/motion_solver).
  double kilograms() const { return number(kLoad) > 0.0 ? 0.0 : kKilogramPerGram * number(kMass); }
  bool carries(int element) const { return element == element_; }
  const ShapeValues& shares() const { return shares_; }
  Vec3 position(const double* x) const {
    Vec3 at = Vec3::Zero();
    for (int a = 0; a < nodes_per_entity(); ++a)
      at += shares_[a] * Eigen::Map<const Vec3>(x + 3 * nodes_of_entity(element_)[a]);
    return at;
  }

 private:
  void changed() override {
    const MaterialPoint point = locate_in_volume(*body_, vector(kAt));
    std::array<double, 4> barycentric{};
    for (element_ = 0; element_ < mesh_->element_count(); ++element_)
      if (std::equal(point.nodes.begin(), point.nodes.end(), mesh_->nodes_of_element(element_).begin())) break;
    for (std::size_t k = 0; k < 4; ++k) barycentric[k] = point.weights[k];
    shares_ = shape_values(mesh_->element, barycentric);
  }

  const TetMesh* body_;
  const FemMesh* mesh_;
  int element_ = 0;
  ShapeValues shares_{};
};

class PointInertia final : public PointLoad {
 public:
  PointInertia(const Effect& effect, const Scene& scene, const FemMesh& mesh) : PointLoad(effect, scene, mesh, {}) {}

  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override {
    const int n = nodes_per_entity();
    for (int e = begin; e < end; ++e) {
      cleared(output, e, n);
      if (!carries(e)) continue;
      const Vec3 momentum = kilograms() * position(input.x);
      if (output.energy != nullptr) output.energy[e] = 0.5 * momentum.dot(position(input.x));
      if (output.residual != nullptr)
        for (int a = 0; a < n; ++a) Eigen::Map<Vec3>(output.residual + 3 * (n * e + a)) = shares()[a] * momentum;
      if (output.tangent == nullptr) continue;
      double* block = output.tangent + static_cast<std::ptrdiff_t>(e) * 9 * pair_count(n);
      for (int a = 0; a < n; ++a)
        for (int b = 0; b <= a; ++b, block += 9)
          Eigen::Map<Mat3>(block).diagonal().setConstant(kilograms() * shares()[a] * shares()[b]);
    }
  }
};

class PointWeight final : public PointLoad {
 public:
  PointWeight(const Effect& effect, const Scene& scene, const FemMesh& mesh)
      : PointLoad(effect, scene, mesh, gravity_of(scene)) {}
  bool has_tangent() const override { return false; }

  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override {
    const int n = nodes_per_entity();
    const Vec3 weight = kilograms() * kStandardGravity * vector(kGravity);
    for (int e = begin; e < end; ++e) {
      cleared(output, e, n);
      if (!carries(e)) continue;
      if (output.energy != nullptr) output.energy[e] = -weight.dot(position(input.x));
      if (output.residual != nullptr)
        for (int a = 0; a < n; ++a) Eigen::Map<Vec3>(output.residual + 3 * (n * e + a)) = -shares()[a] * weight;
    }
  }
};

class AttachedMass final : public Effect {
 public:
  std::string_view kind() const override { return "attached-mass"; }
  std::string_view title() const override { return "Something heavy moves with the tissue"; }
  std::string sentence(std::span<const double> values) const override {
    if (values[kLoad] > 0.0)
      return worded("The load of %.2f N has a mass of its own, %.0f g: it swings with the tissue and slows it down.",
                    values[kLoad], values[kMass]);
    return worded("A mass of %.0f g is attached at (%.0f, %.0f, %.0f) mm.", values[kMass], values[kAt], values[kAt + 1],
                  values[kAt + 2]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 5> kParameters{{{"mass", "g", 0.0, 1e5, 0.0, 20.0},
                                                             {"at.x", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"at.y", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             {"at.z", "mm", -1e4, 1e4, 0.0, 10.0},
                                                             // Above 0: it is what dead loads are made of, whose weight
                                                             // is known; the mass is that of a load of so many N.
                                                             {"load", "N", 0.0, 1e6, 0.0, 1.0, false, true}}};
    return kParameters;
  }
  // In the middle of the skin.
  std::vector<double> neutral(const Scene& scene) const override {
    const std::vector<int> nodes = nodes_of(surface_of(scene.mesh, scene.skin_surface, "the skin"));
    Vec3 middle = Vec3::Zero();
    for (int node : nodes) middle += scene.mesh.node(node) / static_cast<double>(nodes.size());
    return {0.0, middle.x(), middle.y(), middle.z(), 0.0};
  }
  std::vector<EffectNumber> reported(std::span<const double> values) const override {
    std::vector<EffectNumber> numbers = Effect::reported(values);
    numbers.pop_back();
    return numbers;
  }
  void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const override {
    physics.masses.push_back(std::make_unique<PointInertia>(*this, scene, mesh));
    physics.terms.push_back(std::make_unique<PointWeight>(*this, scene, mesh));
  }
  bool is_dynamic() const override { return true; }
};

}  // namespace

const Effect& attached_mass_effect() {
  static const AttachedMass kEffect;
  return kEffect;
}

}  // namespace tissued::core
