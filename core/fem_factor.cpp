#include "core/fem_factor.hpp"

#include <cmath>

#include "core/cholmod_factor.hpp"

namespace tissued::core {

struct FemFactor::Parts {
  CholmodFactor cholmod;
  bool ready = false;
  std::vector<int> node;           // free nodes, ascending
  std::vector<int> column, row;    // the reduced matrix
  std::vector<int> from;           // (entries) of the pattern
  std::vector<double> values;      // (entries)
  std::vector<std::uint8_t> held;  // (nodes), as last factored

  cholmod_sparse view() const {
    return lower_view(column.size() - 1, row.size(), column.data(), row.data(), values.data());
  }
};

FemFactor::FemFactor(const FemPattern& pattern, const std::vector<std::uint8_t>& excluded)
    : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  std::vector<int> reduced(static_cast<std::size_t>(pattern.node_count), -1);
  for (int i = 0; i < pattern.node_count; ++i) {
    if (excluded[i]) continue;
    reduced[i] = static_cast<int>(p.node.size());
    p.node.push_back(i);
  }
  if (p.node.empty()) throw ModelError("no node is free: the whole body is held");
  p.column.push_back(0);
  for (int j : p.node) {
    for (int c = 0; c < 3; ++c) {
      for (int k = pattern.column[3 * j + c]; k < pattern.column[3 * j + c + 1]; ++k) {
        const int node = pattern.row[k] / 3;
        if (reduced[node] < 0) continue;
        p.row.push_back(3 * reduced[node] + pattern.row[k] % 3);
        p.from.push_back(k);
      }
      p.column.push_back(static_cast<int>(p.row.size()));
    }
  }
  p.values.assign(p.row.size(), 1.0);
  if (!p.cholmod.analyze(p.view())) throw ModelError("CHOLMOD cannot analyse the tangent: out of memory?");
}

FemFactor::~FemFactor() = default;
FemFactor::FemFactor(FemFactor&&) noexcept = default;
FemFactor& FemFactor::operator=(FemFactor&&) noexcept = default;

bool FemFactor::factorize(const std::vector<double>& values, const std::vector<std::uint8_t>& held, double shift) {
  Parts& p = *parts_;
  p.ready = false;
  p.held = held;
  double mean = 0.0;
  const int size = rows();
  for (int j = 0; j < size; ++j) mean += values[p.from[p.column[j]]] / size;
  if (!std::isfinite(mean)) return false;
  for (int j = 0; j < size; ++j) {
    const bool column_held = held[p.node[j / 3]] != 0;
    for (int k = p.column[j]; k < p.column[j + 1]; ++k) {
      const bool diagonal = k == p.column[j];  // columns are sorted and lower
      if (column_held || held[p.node[p.row[k] / 3]] != 0)
        p.values[k] = diagonal ? mean : 0.0;
      else
        p.values[k] = values[p.from[k]] + (diagonal ? shift * mean : 0.0);
    }
  }
  p.ready = p.cholmod.factorize(p.view());
  return p.ready;
}

bool FemFactor::ready() const { return parts_->ready; }

Eigen::MatrixXd FemFactor::solve(const Eigen::MatrixXd& b) const {
  const Parts& p = *parts_;
  Eigen::MatrixXd right(rows(), b.cols());
  for (std::size_t k = 0; k < p.node.size(); ++k) {
    auto rows = right.middleRows<3>(3 * static_cast<Eigen::Index>(k));
    if (p.held[p.node[k]])
      rows.setZero();
    else
      rows = b.middleRows<3>(3 * p.node[k]);
  }
  const Eigen::MatrixXd solved = p.cholmod.solve(right);
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(b.rows(), b.cols());
  for (std::size_t k = 0; k < p.node.size(); ++k)
    x.middleRows<3>(3 * p.node[k]) = solved.middleRows<3>(3 * static_cast<Eigen::Index>(k));
  return x;
}

int FemFactor::rows() const { return static_cast<int>(parts_->column.size()) - 1; }
double FemFactor::entries() const { return parts_->cholmod.common.lnz; }
double FemFactor::flops() const { return parts_->cholmod.common.fl; }

}  // namespace tissued::core
