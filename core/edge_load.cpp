#include "core/edge_load.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tissued::core {

namespace {

// A stretch of the edge: its ends, and of quadratic elements the node between them.
struct Stretch {
  std::array<int, 3> nodes;
  int count;
  double share;  // of the edge's length
};

bool lies_on(const std::array<Vec3, 2>& edge, const Vec3& point) {
  constexpr double kNear = 1e-3;  // mm
  const Vec3 way = edge[1] - edge[0];
  const double along = (point - edge[0]).dot(way) / way.squaredNorm();
  return along > -1e-6 && along < 1.0 + 1e-6 && (point - edge[0] - along * way).norm() < kNear;
}

std::vector<Stretch> stretches_of(const FemModel& model, const std::array<Vec3, 2>& edge) {
  const FemMesh& mesh = model.mesh();
  const double length = (edge[1] - edge[0]).norm();
  const auto place = [&mesh](int node) -> Vec3 { return mesh.rest.row(node).transpose(); };
  std::vector<std::array<int, 2>> pairs;
  for (const Tet& tet : model.scene().mesh.tets)
    for (const auto& [i, j] : kTetEdges) {
      if (!lies_on(edge, place(tet[i])) || !lies_on(edge, place(tet[j]))) continue;
      pairs.push_back({std::min(tet[i], tet[j]), std::max(tet[i], tet[j])});
    }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<Stretch> stretches;
  double covered = 0.0;
  for (const auto& [i, j] : pairs) {
    const bool is_linear = mesh.element == FemElement::p1;
    stretches.push_back(
        {{i, j, is_linear ? -1 : mesh.middle_of(i, j)}, is_linear ? 2 : 3, (place(i) - place(j)).norm() / length});
    covered += stretches.back().share;
  }
  if (std::abs(covered - 1.0) > 1e-3) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "a load lies along (%g, %g, %g) to (%g, %g, %g) mm, where the mesh has edges along %.0f %% of it",
                  edge[0].x(), edge[0].y(), edge[0].z(), edge[1].x(), edge[1].y(), edge[1].z(), 100.0 * covered);
    throw ModelError(text);
  }
  return stretches;
}

// Integrals of shape functions over a stretch of length 1, and of their products.
constexpr double kLinear[2] = {0.5, 0.5}, kQuadratic[3] = {1.0 / 6.0, 1.0 / 6.0, 4.0 / 6.0};
constexpr double kLinearMass[2][2] = {{2.0 / 6.0, 1.0 / 6.0}, {1.0 / 6.0, 2.0 / 6.0}};
constexpr double kQuadraticMass[3][3] = {{4.0 / 30.0, -1.0 / 30.0, 2.0 / 30.0},
                                         {-1.0 / 30.0, 4.0 / 30.0, 2.0 / 30.0},
                                         {2.0 / 30.0, 2.0 / 30.0, 16.0 / 30.0}};

}  // namespace

Eigen::VectorXd forces_of(const FemModel& model, std::span<const EdgeLoad> loads) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * model.mesh().node_count());
  for (const EdgeLoad& load : loads)
    for (const Stretch& stretch : stretches_of(model, load.edge))
      for (int a = 0; a < stretch.count; ++a)
        force.segment<3>(3 * stretch.nodes[a]) +=
            kMillinewtonPerNewton * stretch.share * (stretch.count == 2 ? kLinear[a] : kQuadratic[a]) * load.force;
  return force;
}

std::vector<double> masses_of(const FemModel& model, std::span<const EdgeLoad> loads) {
  const FemPattern& pattern = model.pattern();
  std::vector<double> values(pattern.entries(), 0.0);
  for (const EdgeLoad& load : loads) {
    if (load.mass == 0.0) continue;
    for (const Stretch& stretch : stretches_of(model, load.edge))
      for (int a = 0; a < stretch.count; ++a)
        for (int b = 0; b < stretch.count; ++b) {
          const int row = stretch.nodes[a], column = stretch.nodes[b];
          if (row < column) continue;
          const double product = stretch.count == 2 ? kLinearMass[a][b] : kQuadraticMass[a][b];
          const int block = pattern.block(row, column);
          for (int c = 0; c < 3; ++c)
            values[pattern.entry(column, block, c) + (row == column ? 0 : c)] +=
                kKilogramPerGram * load.mass * stretch.share * product;
        }
  }
  return values;
}

}  // namespace tissued::core
