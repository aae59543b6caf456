#include "core/fem_pattern.hpp"

#include <algorithm>

namespace tissued::core {

int FemPattern::block(int row_node, int column_node) const {
  const auto begin = block_row.begin() + block_begin[column_node],
             end = block_row.begin() + block_begin[column_node + 1];
  return static_cast<int>(std::lower_bound(begin, end, row_node) - block_row.begin());
}

int FemPattern::entry(int column_node, int block, int c) const {
  const int place = block - block_begin[column_node];
  return column[3 * column_node + c] + (place == 0 ? 0 : 3 - c + 3 * (place - 1));
}

void FemPattern::multiply(const std::vector<double>& values, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
  y.setZero(x.size());
  for (int j = 0; j < 3 * node_count; ++j) {
    double sum = values[column[j]] * x[j];
    for (int k = column[j] + 1; k < column[j + 1]; ++k) {
      y[row[k]] += values[k] * x[j];
      sum += values[k] * x[row[k]];
    }
    y[j] += sum;
  }
}

FemPattern make_fem_pattern(int node_count, const std::vector<std::unique_ptr<FemTerm>>& terms) {
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(node_count));
  for (int i = 0; i < node_count; ++i) rows[i].push_back(i);
  for (const auto& term : terms) {
    for (int e = 0; e < term->entity_count(); ++e) {
      const std::span<const int> nodes = term->nodes_of_entity(e);
      for (int i : nodes)
        for (int j : nodes)
          if (i > j) rows[j].push_back(i);
    }
  }
  FemPattern pattern;
  pattern.node_count = node_count;
  pattern.block_begin.push_back(0);
  pattern.column.push_back(0);
  for (int j = 0; j < node_count; ++j) {
    std::sort(rows[j].begin(), rows[j].end());
    rows[j].erase(std::unique(rows[j].begin(), rows[j].end()), rows[j].end());
    pattern.block_row.insert(pattern.block_row.end(), rows[j].begin(), rows[j].end());
    pattern.block_begin.push_back(static_cast<int>(pattern.block_row.size()));
    for (int c = 0; c < 3; ++c) {
      for (int i : rows[j])
        for (int r = i == j ? c : 0; r < 3; ++r) pattern.row.push_back(3 * i + r);
      pattern.column.push_back(static_cast<int>(pattern.row.size()));
    }
  }
  return pattern;
}

}  // namespace tissued::core
