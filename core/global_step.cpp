#include "core/global_step.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

Eigen::VectorXd lumped_masses(const TetMesh& mesh, double density) {
  Eigen::VectorXd masses = Eigen::VectorXd::Zero(mesh.node_count());
  for (const Tet& tet : mesh.tets) {
    const double quarter = signed_volume(mesh, tet) * density * kKilogramPerDensityVolume / 4.0;
    for (int node : tet) masses[node] += quarter;
  }
  return masses;
}

SparseMatrix weighted_laplacian(const TetMesh& mesh, const std::vector<ElementBlock>& blocks) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(mesh.tet_count()) * 10);
  for (int i = 0; i < mesh.tet_count(); ++i) {
    const ElementBlock& block = blocks[i / kLanes];
    const int lane = i % kLanes;
    Eigen::Matrix<double, 4, 3> g;
    for (int a = 0; a < 3; ++a)
      for (int axis = 0; axis < 3; ++axis) g(a + 1, axis) = block.gradient[a][axis][lane];
    g.row(0) = -(g.row(1) + g.row(2) + g.row(3));
    const Eigen::Matrix4d local = block.stiffness[lane] * block.volume[lane] * g * g.transpose();
    const Tet& tet = mesh.tets[i];
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        if (tet[a] >= tet[b]) entries.emplace_back(tet[a], tet[b], local(a, b));
  }
  SparseMatrix lower(mesh.node_count(), mesh.node_count());
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

SparseMatrix restrict_lower(const SparseMatrix& lower, const std::vector<int>& nodes) {
  std::vector<int> index(static_cast<std::size_t>(lower.rows()), -1);
  for (std::size_t k = 0; k < nodes.size(); ++k) index[nodes[k]] = static_cast<int>(k);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(lower.nonZeros()));
  for (int column = 0; column < lower.outerSize(); ++column) {
    if (index[column] < 0) continue;
    for (SparseMatrix::InnerIterator it(lower, column); it; ++it)
      if (index[it.row()] >= 0) entries.emplace_back(index[it.row()], index[column], it.value());
  }
  const int size = static_cast<int>(nodes.size());
  SparseMatrix out(size, size);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

namespace {

std::vector<int> complement(const std::vector<int>& nodes, int count) {
  std::vector<std::uint8_t> taken(static_cast<std::size_t>(count), 0);
  for (int node : nodes) taken[node] = 1;
  std::vector<int> rest;
  for (int i = 0; i < count; ++i)
    if (!taken[i]) rest.push_back(i);
  return rest;
}

std::vector<int> inverse_index(const std::vector<int>& nodes, int count) {
  std::vector<int> index(static_cast<std::size_t>(count), -1);
  for (std::size_t k = 0; k < nodes.size(); ++k) index[nodes[k]] = static_cast<int>(k);
  return index;
}

SparseMatrix global_matrix(const TetMesh& mesh, const std::vector<ElementBlock>& blocks, const Eigen::VectorXd& masses,
                           const std::vector<int>& free_nodes, double time_step) {
  SparseMatrix k = restrict_lower(weighted_laplacian(mesh, blocks), free_nodes);
  for (std::size_t i = 0; i < free_nodes.size(); ++i) {
    const int row = static_cast<int>(i);
    k.coeffRef(row, row) += masses[free_nodes[i]] / (time_step * time_step);
  }
  return k;
}

}  // namespace

GlobalSystem::GlobalSystem(const TetMesh& mesh, const std::vector<ElementBlock>& blocks, const Eigen::VectorXd& masses,
                           const std::vector<int>& fixed_nodes, double time_step)
    : time_step_(time_step),
      free_nodes_(complement(fixed_nodes, mesh.node_count())),
      free_index_(inverse_index(free_nodes_, mesh.node_count())),
      factor_(global_matrix(mesh, blocks, masses, free_nodes_, time_step)) {
  const int nodes = mesh.node_count();
  std::vector<std::vector<std::int64_t>> per_node(static_cast<std::size_t>(nodes));
  constexpr std::int64_t kForceSize = sizeof(ElementForce) / sizeof(double);
  for (int i = 0; i < mesh.tet_count(); ++i)
    for (int a = 0; a < 4; ++a)
      per_node[mesh.tets[i][a]].push_back(i / kLanes * kForceSize + a * 3 * kLanes + i % kLanes);
  row_node_.reserve(free_nodes_.size());
  incident_begin_.push_back(0);
  for (int row : factor_.order()) {
    const int node = free_nodes_[row];
    row_node_.push_back(node);
    incident_.insert(incident_.end(), per_node[node].begin(), per_node[node].end());
    incident_begin_.push_back(static_cast<std::int64_t>(incident_.size()));
  }
}

}  // namespace tissued::core
