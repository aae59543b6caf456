#include "core/effects/skin.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "core/effects/effect_numbers.hpp"
#include "core/effects/facet.hpp"
#include "core/effects/wording.hpp"
#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

constexpr int kStiffness = 0;  // of the numbers

using Surface = Eigen::Matrix<double, 3, 2>;  // columns: along two unit vectors of the facet at rest

// Energy E h / 6 (tr C + 1/det C - 3) of a surface gradient F, C = F^T F, and its derivatives, for E h = 1.
struct Sheet {
  double energy;
  Surface stress;
  Eigen::Matrix<double, 6, 6> tangent;  // of F by columns
};

Sheet sheet(const Surface& f, bool tangent) {
  const Eigen::Matrix2d c = f.transpose() * f;
  const double d = c.determinant();
  Sheet out;
  out.energy = d > 0.0 ? (c.trace() + 1.0 / d - 3.0) / 6.0 : std::numeric_limits<double>::infinity();
  if (!(d > 0.0)) {
    out.stress.setZero();
    out.tangent.setZero();
    return out;
  }
  // dd/dF = 2 F adj(C).
  Eigen::Matrix2d adjugate;
  adjugate << c(1, 1), -c(0, 1), -c(1, 0), c(0, 0);
  const Surface slope = 2.0 * f * adjugate;
  out.stress = (2.0 * f - slope / (d * d)) / 6.0;
  if (!tangent) return out;
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> s(slope.data());
  const Vec3 a = f.col(0), b = f.col(1);
  Eigen::Matrix<double, 6, 6> curvature;  // d2d/dF2
  curvature.topLeftCorner<3, 3>() = 2.0 * (c(1, 1) * Mat3::Identity() - b * b.transpose());
  curvature.bottomRightCorner<3, 3>() = 2.0 * (c(0, 0) * Mat3::Identity() - a * a.transpose());
  curvature.topRightCorner<3, 3>() = 2.0 * (2.0 * a * b.transpose() - b * a.transpose() - c(0, 1) * Mat3::Identity());
  curvature.bottomLeftCorner<3, 3>() = curvature.topRightCorner<3, 3>().transpose();
  out.tangent = (2.0 / (d * d * d) * s * s.transpose() - curvature / (d * d)) / 6.0;
  out.tangent.diagonal().array() += 2.0 / 6.0;
  return out;
}

class Membrane final : public WithNumbers<FemTerm> {
 public:
  Membrane(const Effect& effect, const Scene& scene, const FemMesh& mesh) : WithNumbers(effect, scene) {
    std::set<Triangle> seen;
    std::vector<std::string> groups{scene.skin_surface};
    for (const Pad& pad : scene.pads) groups.push_back(pad.surface);
    for (const std::string& group : groups) {
      for (const Triangle& triangle : surface_of(scene.mesh, group, "the skin").triangles) {
        Triangle key = triangle;
        std::sort(key.begin(), key.end());
        if (seen.insert(key).second) add(make_facet(mesh, triangle));
      }
    }
  }

  std::string_view name() const override { return "skin"; }
  int entity_count() const override { return static_cast<int>(facets_.size()); }
  int nodes_per_entity() const override { return facets_.empty() ? 3 : facets_.front().count; }
  std::span<const int> nodes_of_entity(int entity) const override {
    return {facets_[entity].nodes.data(), static_cast<std::size_t>(facets_[entity].count)};
  }

  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override {
    for (int e = begin; e < end; ++e) {
      const auto [residual, tangent] = cleared(output, e, nodes_per_entity());
      if (number(kStiffness) == 0.0) continue;
      for (std::size_t q = 0; q < points_; ++q) {
        const Gradients& g = gradients_[points_ * static_cast<std::size_t>(e) + q];
        Surface f = Surface::Zero();
        for (int a = 0; a < facets_[e].count; ++a)
          f += Eigen::Map<const Vec3>(input.x + 3 * facets_[e].nodes[a]) * g[a].transpose();
        const double weight = number(kStiffness) * facets_[e].area * weight_of(q);
        const Sheet point = sheet(f, tangent != nullptr);
        if (output.energy != nullptr) output.energy[e] += weight * point.energy;
        if (residual != nullptr) add_residual(facets_[e].count, g, weight * point.stress, residual);
        if (tangent != nullptr) add_tangent(facets_[e].count, g, weight * point.tangent, tangent);
      }
    }
  }

 private:
  // Of the shape functions, along the facet's two unit vectors.
  using Gradients = std::array<Eigen::Vector2d, kMostFacetNodes>;

  // Three points are exact for quadratic facets whose stretch is quadratic; the gradient of linear ones is constant.
  static std::array<double, 3> point(std::size_t points, std::size_t q) {
    std::array<double, 3> barycentric{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
    if (points == 3)
      for (std::size_t k = 0; k < 3; ++k) barycentric[k] = k == q ? 2.0 / 3.0 : 1.0 / 6.0;
    return barycentric;
  }
  double weight_of(std::size_t) const { return 1.0 / static_cast<double>(points_); }

  void add(const Facet& facet) {
    points_ = facet.count == 3 ? 1 : 3;
    const Vec3 first = facet.slope[0].normalized(), second = facet.normal.cross(first);
    for (std::size_t q = 0; q < points_; ++q) {
      const std::array<Vec3, kMostFacetNodes> slopes = facet_slopes(facet, point(points_, q));
      Gradients gradients;
      for (std::size_t a = 0; a < slopes.size(); ++a) gradients[a] = {slopes[a].dot(first), slopes[a].dot(second)};
      gradients_.push_back(gradients);
    }
    facets_.push_back(facet);
  }

  static void add_residual(int count, const Gradients& g, const Surface& stress, double* residual) {
    for (int a = 0; a < count; ++a) Eigen::Map<Vec3>(residual + 3 * a) += stress * g[a];
  }

  static void add_tangent(int count, const Gradients& g, const Eigen::Matrix<double, 6, 6>& tangent, double* block) {
    for (int a = 0; a < count; ++a) {
      const Eigen::Matrix<double, 3, 6> row = g[a][0] * tangent.topRows<3>() + g[a][1] * tangent.bottomRows<3>();
      for (int b = 0; b <= a; ++b, block += 9)
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(block).noalias() +=
            row.leftCols<3>() * g[b][0] + row.rightCols<3>() * g[b][1];
    }
  }

  std::vector<Facet> facets_;
  std::vector<Gradients> gradients_;  // (facets x points)
  std::size_t points_ = 1;
};

class Skin final : public Effect {
 public:
  std::string_view kind() const override { return "skin"; }
  std::string_view title() const override { return "A stiffer skin covers the tissue"; }
  std::string sentence(std::span<const double> values) const override {
    return worded("A skin of stiffness %.1f kPa mm (modulus times thickness) covers the tissue.", values[kStiffness]);
  }
  std::span<const EffectParameter> parameters() const override {
    static const std::array<EffectParameter, 1> kParameters{{{"stiffness", "kPa mm", 0.0, 1e5, 0.0, 30.0}}};
    return kParameters;
  }
  void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const override {
    physics.terms.push_back(std::make_unique<Membrane>(*this, scene, mesh));
  }
};

}  // namespace

const Effect& skin_effect() {
  static const Skin kEffect;
  return kEffect;
}

}  // namespace tissued::core
