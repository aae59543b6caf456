#include "core/contact_surface.hpp"

#include <algorithm>
#include <map>

#include "core/skin_outline.hpp"

namespace tissued::core {

ContactSurface::ContactSurface(const Scene& scene, const SparseCholesky& factor, const std::vector<int>& free_index) {
  if (scene.probes.empty()) return;
  const SkinOutline outline = skin_outline(scene);
  std::vector<int> row_of_free(static_cast<std::size_t>(factor.size()));
  for (int k = 0; k < factor.size(); ++k) row_of_free[factor.order()[k]] = k;
  std::map<int, int> column_of;
  std::vector<int> free_skin;
  for (const auto& [node, normal] : outline.nodes) {
    if (free_index[node] < 0) continue;
    const int column = static_cast<int>(free_skin.size());
    free_skin.push_back(free_index[node]);
    column_of.emplace(node, column);
    samples_.push_back(
        {1, {node, node}, {1.0, 0.0}, {row_of_free[free_index[node]], -1}, {column, -1}, normal.normalized()});
  }
  for (const auto& [edge, normal] : outline.edges) {
    if ((scene.mesh.node(edge[0]) - scene.mesh.node(edge[1])).norm() <= kSpacing) continue;
    ContactSample sample{2, edge, {0.5, 0.5}, {-1, -1}, {-1, -1}, normal.normalized()};
    for (int a = 0; a < 2; ++a) {
      if (free_index[edge[a]] < 0) continue;
      sample.rows[a] = row_of_free[free_index[edge[a]]];
      sample.columns[a] = column_of.at(edge[a]);
    }
    if (sample.columns[0] >= 0 || sample.columns[1] >= 0) samples_.push_back(sample);
  }
  const auto size = static_cast<Eigen::Index>(free_skin.size());
  compliance_.resize(size, size);
  constexpr Eigen::Index kChunk = 64;  // right-hand sides a solve: bounds the memory on large meshes
  for (Eigen::Index begin = 0; begin < size; begin += kChunk) {
    const Eigen::Index width = std::min(kChunk, size - begin);
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(factor.size(), width);
    for (Eigen::Index j = 0; j < width; ++j) unit(free_skin[static_cast<std::size_t>(begin + j)], j) = 1.0;
    const Eigen::MatrixXd answer = factor.solve(unit);
    for (Eigen::Index i = 0; i < size; ++i)
      compliance_.block(i, begin, 1, width) = answer.row(free_skin[static_cast<std::size_t>(i)]).cast<float>();
  }
}

}  // namespace tissued::core
