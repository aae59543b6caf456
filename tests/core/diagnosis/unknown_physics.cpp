#include "tests/core/diagnosis/unknown_physics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

namespace tissued::core::testing {

namespace {

using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// -p V over the quadratic tetrahedra of the ball; history: the time since rest, s.
class CavityPressure final : public FemTerm {
 public:
  CavityPressure(std::vector<std::array<int, 10>> elements, double rate)
      : elements_(std::move(elements)), rate_(rate) {}

  std::string_view name() const override { return "cavity"; }
  int entity_count() const override { return static_cast<int>(elements_.size()); }
  int nodes_per_entity() const override { return 10; }
  std::span<const int> nodes_of_entity(int entity) const override {
    return elements_[static_cast<std::size_t>(entity)];
  }
  std::size_t history_size() const override { return 1; }
  void accept(const TermInput& input, double* history) const override { history[0] = time_of(input); }

  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override {
    const double pressure = rate_ * time_of(input);
    for (int e = begin; e < end; ++e) {
      const auto [residual, tangent] = cleared(output, e, 10);
      const auto& nodes = elements_[static_cast<std::size_t>(e)];
      for (int q = 0; q < 4; ++q) {
        const std::array<Vec3, 10> slopes = slopes_at(q);
        Mat3 f = Mat3::Zero();
        for (std::size_t a = 0; a < 10; ++a)
          f += Eigen::Map<const Vec3>(input.x + 3 * nodes[a]) * slopes[a].transpose();
        const double weight = -pressure / 24.0;  // a quarter of the unit tetrahedron
        if (output.energy != nullptr) output.energy[e] += weight * f.determinant();
        Mat3 cofactor;
        for (int j = 0; j < 3; ++j) cofactor.col(j) = f.col((j + 1) % 3).cross(f.col((j + 2) % 3));
        for (int a = 0; a < 10; ++a) {
          const Vec3& slope = slopes[static_cast<std::size_t>(a)];
          if (residual != nullptr) Eigen::Map<Vec3>(residual + 3 * a) += weight * cofactor * slope;
          if (tangent == nullptr) continue;
          for (int b = 0; b <= a; ++b)
            Eigen::Map<RowMat3>(tangent + 9 * pair_index(a, b)) -=
                weight * cross_matrix(f * slope.cross(slopes[static_cast<std::size_t>(b)]));
        }
      }
    }
  }

 private:
  static double time_of(const TermInput& input) {
    return (input.history != nullptr ? input.history[0] : 0.0) + input.time_step;
  }
  // Of the shape functions, by the first three barycentric coordinates but one, at the points of the rule of degree 2.
  static std::array<Vec3, 10> slopes_at(int q) {
    constexpr double kNear = 0.5854101966249685, kFar = 0.1381966011250105;
    std::array<double, 4> at{kFar, kFar, kFar, kFar};
    at[static_cast<std::size_t>(q)] = kNear;
    const std::array<Vec3, 4> of{Vec3(-1, -1, -1), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    std::array<Vec3, 10> out;
    for (std::size_t a = 0; a < 4; ++a) out[a] = (4.0 * at[a] - 1.0) * of[a];
    for (std::size_t k = 0; k < 6; ++k) {
      const auto a = static_cast<std::size_t>(kTetEdges[k][0]), b = static_cast<std::size_t>(kTetEdges[k][1]);
      out[4 + k] = 4.0 * (at[a] * of[b] + at[b] * of[a]);
    }
    return out;
  }
  std::vector<std::array<int, 10>> elements_;
  double rate_;
};

// k/2 (L - L0)^2 of every string, where it is stretched.
class Cable final : public FemTerm {
 public:
  struct String {
    std::array<int, 2> nodes;
    double rest_length;  // mm
  };
  Cable(std::vector<String> strings, double stiffness)
      : strings_(std::move(strings)), stiffness_(kMillinewtonPerNewton * stiffness) {}

  std::string_view name() const override { return "cable"; }
  int entity_count() const override { return static_cast<int>(strings_.size()); }
  int nodes_per_entity() const override { return 2; }
  std::span<const int> nodes_of_entity(int entity) const override {
    return strings_[static_cast<std::size_t>(entity)].nodes;
  }

  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override {
    for (int e = begin; e < end; ++e) {
      const auto [residual, tangent] = cleared(output, e, 2);
      const auto& [nodes, rest_length] = strings_[static_cast<std::size_t>(e)];
      const Vec3 along =
          Eigen::Map<const Vec3>(input.x + 3 * nodes[1]) - Eigen::Map<const Vec3>(input.x + 3 * nodes[0]);
      const double length = along.norm(), stretch = length - rest_length;
      if (stretch <= 0.0) continue;
      const Vec3 axis = along / length, force = stiffness_ * stretch * axis;
      if (output.energy != nullptr) output.energy[e] = 0.5 * stiffness_ * stretch * stretch;
      if (residual != nullptr) {
        Eigen::Map<Vec3>(residual + 0) = -force;
        Eigen::Map<Vec3>(residual + 3) = force;
      }
      if (tangent == nullptr) continue;
      const Mat3 square = axis * axis.transpose();
      const Mat3 slope = stiffness_ * (square + stretch / length * (Mat3::Identity() - square));
      Eigen::Map<RowMat3>(tangent + 9 * pair_index(0, 0)) = slope;
      Eigen::Map<RowMat3>(tangent + 9 * pair_index(1, 0)) = -slope;
      Eigen::Map<RowMat3>(tangent + 9 * pair_index(1, 1)) = slope;
    }
  }

 private:
  std::vector<String> strings_;
  double stiffness_;
};

// Of all nodes, nearest first.
std::vector<int> nearest_nodes(const FemMesh& mesh, const Vec3& place, std::size_t count) {
  std::vector<int> nodes(static_cast<std::size_t>(mesh.node_count()));
  std::iota(nodes.begin(), nodes.end(), 0);
  const auto distance = [&](int node) { return (mesh.rest.row(node).transpose() - place).norm(); };
  std::sort(nodes.begin(), nodes.end(), [&](int a, int b) { return distance(a) < distance(b); });
  nodes.resize(count);
  return nodes;
}

}  // namespace

void FluidCavity::add_to(const Scene&, const FemMesh& mesh, FemPhysics& physics) const {
  std::vector<std::array<int, 10>> inside;
  for (int e = 0; e < mesh.element_count(); ++e) {
    const std::span<const int> nodes = mesh.nodes_of_element(e);
    if (nodes.size() != 10) throw ModelError("a cavity needs quadratic elements");
    Vec3 middle = Vec3::Zero();
    for (std::size_t a = 0; a < 4; ++a) middle += 0.25 * mesh.rest.row(nodes[a]).transpose();
    if ((middle - center_).norm() > radius_) continue;
    inside.emplace_back();
    std::copy(nodes.begin(), nodes.end(), inside.back().begin());
  }
  physics.terms.push_back(std::make_unique<CavityPressure>(std::move(inside), rate_));
}

void InnerCable::add_to(const Scene&, const FemMesh& mesh, FemPhysics& physics) const {
  constexpr std::size_t kStrings = 12;
  const std::vector<int> from = nearest_nodes(mesh, from_, kStrings), to = nearest_nodes(mesh, to_, kStrings);
  std::vector<Cable::String> strings;
  for (std::size_t i = 0; i < kStrings; ++i) {
    const double length = (mesh.rest.row(from[i]) - mesh.rest.row(to[i])).norm();
    strings.push_back({{from[i], to[i]}, length - tautness_});
  }
  physics.terms.push_back(std::make_unique<Cable>(std::move(strings), stiffness_ / kStrings));
}

}  // namespace tissued::core::testing
