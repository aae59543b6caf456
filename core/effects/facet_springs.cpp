#include "core/effects/facet_springs.hpp"

#include <algorithm>

namespace tissued::core {

namespace {

using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// The shape functions at the points of the rule.
const std::array<std::array<double, kMostFacetNodes>, kFacetPoints>& shapes(int count) {
  const auto tabulate = [](int nodes) {
    std::array<std::array<double, kMostFacetNodes>, kFacetPoints> table;
    for (std::size_t q = 0; q < kFacetPoints; ++q) table[q] = facet_shapes(nodes, facet_rule()[q].barycentric);
    return table;
  };
  static const auto kLinear = tabulate(3), kQuadratic = tabulate(6);
  return count == 3 ? kLinear : kQuadratic;
}

}  // namespace

Mat3 plate_springs(const Vec3& normal, double across, double along) {
  const Mat3 square = normal * normal.transpose();
  return across * square + along * (Mat3::Identity() - square);
}

FacetSprings::FacetSprings(const Effect& effect, const Scene& scene, const FemMesh& mesh, std::vector<Facet> facets,
                           std::vector<int> pads)
    : WithNumbers(effect, scene), mesh_(&mesh), facets_(std::move(facets)), pads_(std::move(pads)) {
  for (const Pad& pad : scene.pads) centers_.push_back(pad.center);
}

void FacetSprings::changed() {
  stiffness_.clear();
  for (std::size_t e = 0; e < facets_.size(); ++e)
    for (const FacetPoint& point : facet_rule())
      stiffness_.push_back(stiffness(facets_[e], pads_[e], rest_on_facet(*mesh_, facets_[e], point.barycentric)));
}

FacetSprings::Support FacetSprings::support_of(int entity, const TermInput& input) const {
  const int pad = pads_[entity];
  if (pad < 0) return {Mat3::Identity(), Vec3::Zero(), true};
  if (static_cast<std::size_t>(pad) >= input.pads.size() || input.pads[pad].kind != PadInput::Kind::pose)
    return {Mat3::Identity(), Vec3::Zero(), false};
  const PadInput& pose = input.pads[pad];
  return {pose.rotation, pose.center - pose.rotation * centers_[pad], true};
}

Mat3 FacetSprings::weighted(int entity, int point, const Support& support) const {
  const double weight = facet_rule()[point].weight * facets_[entity].area;
  const Mat3& stiffness = stiffness_[static_cast<std::size_t>(kFacetPoints * entity + point)];
  return weight * (support.rotation * stiffness * support.rotation.transpose());
}

Vec3 FacetSprings::away(int entity, int point, const Support& support, const double* x) const {
  const Facet& facet = facets_[entity];
  const auto& shape = shapes(facet.count)[point];
  Vec3 distance = Vec3::Zero();
  for (int a = 0; a < facet.count; ++a) {
    const Vec3 held = support.rotation * mesh_->rest.row(facet.nodes[a]).transpose() + support.shift;
    distance += shape[a] * (Eigen::Map<const Vec3>(x + 3 * facet.nodes[a]) - held);
  }
  return distance;
}

void FacetSprings::evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const {
  const int count = nodes_per_entity();
  for (int e = begin; e < end; ++e) {
    const auto [residual, tangent] = cleared(output, e, count);
    const Support support = support_of(e, input);
    if (!support.active) continue;
    for (int q = 0; q < kFacetPoints; ++q) {
      const auto& shape = shapes(count)[q];
      const Mat3 stiffness = weighted(e, q, support);
      const Vec3 stretch = away(e, q, support, input.x), force = stiffness * stretch;
      if (output.energy != nullptr) output.energy[e] += 0.5 * stretch.dot(force);
      if (residual != nullptr)
        for (int a = 0; a < count; ++a) Eigen::Map<Vec3>(residual + 3 * a) += shape[a] * force;
      double* block = tangent;
      if (tangent == nullptr) continue;
      for (int a = 0; a < count; ++a)
        for (int b = 0; b <= a; ++b, block += 9) Eigen::Map<RowMat3>(block) += shape[a] * shape[b] * stiffness;
    }
  }
}

void FacetSprings::add_pad_forces(const TermInput& input, std::span<Vec3> forces) const {
  for (int e = 0; e < entity_count(); ++e) {
    const Support support = support_of(e, input);
    if (pads_[e] < 0 || !support.active) continue;
    for (int q = 0; q < kFacetPoints; ++q)
      forces[pads_[e]] -= weighted(e, q, support) * away(e, q, support, input.x) / kMillinewtonPerNewton;
  }
}

void FacetSprings::add_pad_slope(int pad, const Vec3& axis, const TermInput& input, Eigen::VectorXd& slope) const {
  for (int e = 0; e < entity_count(); ++e) {
    const Support support = support_of(e, input);
    if (pads_[e] != pad || !support.active) continue;
    for (int q = 0; q < kFacetPoints; ++q) {
      const Vec3 row = weighted(e, q, support) * axis / kMillinewtonPerNewton;
      for (int a = 0; a < facets_[e].count; ++a)
        slope.segment<3>(3 * facets_[e].nodes[a]) -= shapes(facets_[e].count)[q][a] * row;
    }
  }
}

}  // namespace tissued::core
