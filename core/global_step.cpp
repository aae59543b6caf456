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

SparseMatrix weighted_laplacian(int nodes, const std::vector<StrainDomain>& domains, double weight_scale) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(domains.size() * 10);
  for (const StrainDomain& domain : domains) {
    const double weight = weight_scale * domain.stiffness * domain.volume;
    for (std::size_t a = 0; a < domain.nodes.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b)  // ascending: b's node is not above a's
        entries.emplace_back(domain.nodes[a], domain.nodes[b], weight * domain.gradients[a].dot(domain.gradients[b]));
  }
  SparseMatrix lower(nodes, nodes);
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

SparseMatrix global_matrix(const SparseMatrix& laplacian, const Eigen::VectorXd& masses,
                           const std::vector<int>& free_nodes, double time_step) {
  SparseMatrix k = restrict_lower(laplacian, free_nodes);
  for (std::size_t i = 0; i < free_nodes.size(); ++i) {
    const int row = static_cast<int>(i);
    k.coeffRef(row, row) += masses[free_nodes[i]] / (time_step * time_step);
  }
  return k;
}

}  // namespace

GlobalSystem::GlobalSystem(const SparseMatrix& laplacian, const DomainBlocks& blocks, const Eigen::VectorXd& masses,
                           const std::vector<int>& fixed_nodes, double time_step)
    : time_step_(time_step),
      free_nodes_(complement(fixed_nodes, static_cast<int>(masses.size()))),
      free_index_(inverse_index(free_nodes_, static_cast<int>(masses.size()))),
      factor_(global_matrix(laplacian, masses, free_nodes_, time_step)) {
  std::vector<std::vector<std::int64_t>> per_node(static_cast<std::size_t>(masses.size()));
  constexpr std::int64_t kForceSize = sizeof(CornerForce) / sizeof(double);
  for (int b = 0; b < blocks.count(); ++b) {
    const DomainBlock& block = blocks.blocks[b];
    for (std::int64_t a = 0; a < block.corner_count; ++a) {
      const DomainCorner& corner = blocks.corners[static_cast<std::size_t>(block.first_corner + a)];
      for (int lane = 0; lane < kLanes; ++lane) {
        const bool repeated_node =
            a > 0 && corner.row[lane] == blocks.corners[static_cast<std::size_t>(block.first_corner)].row[lane];
        if (blocks.domain[static_cast<std::size_t>(b) * kLanes + lane] < 0 || repeated_node) continue;
        per_node[corner.row[lane] / 4].push_back((block.first_corner + a) * kForceSize + lane);
      }
    }
  }
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
