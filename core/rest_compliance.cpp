#include "core/rest_compliance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "core/dense_kernels.hpp"

namespace tissued::core {

namespace {

// A glued plate is stiff: so many of its nodes, spread out, stand for all.
constexpr std::size_t kNodesOfPad = 48;

std::vector<int> spread_nodes(const Model& model, const std::vector<int>& nodes) {
  std::vector<int> free, chosen;
  for (int node : nodes)
    if (model.system().free_index()[node] >= 0) free.push_back(node);
  if (free.empty()) return chosen;
  std::vector<double> distance(free.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  while (chosen.size() < std::min(kNodesOfPad, free.size())) {
    chosen.push_back(free[next]);
    for (std::size_t k = 0; k < free.size(); ++k)
      distance[k] = std::min(distance[k], (model.rest().row(free[k]) - model.rest().row(chosen.back())).squaredNorm());
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
  }
  return chosen;
}

void put_point(const Model& model, const MaterialPoint& point, int column, Eigen::MatrixXd& right) {
  for (int a = 0; a < point.count; ++a)
    if (const int free = model.system().free_index()[point.nodes[a]]; free >= 0)
      for (int axis = 0; axis < 3; ++axis) right(3 * free + axis, column + axis) += point.weights[a];
}

// Nodes of a support that is partly loose: as good as held along their axes.
void add_support(const Model& model, std::vector<Eigen::Triplet<double>>& entries) {
  constexpr double kFirm = 1e3;  // of the ADMM weights, which are stiffer than the body
  const HoldableNodes& holdable = model.holdable();
  for (int k = 0; k < holdable.count(); ++k) {
    if (static_cast<std::size_t>(holdable.group[k]) < model.pad_nodes().size()) continue;
    const int row = 3 * model.system().free_index()[holdable.node[k]];
    const double firm = kFirm * model.laplacian().coeff(holdable.node[k], holdable.node[k]);
    const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> axes =
        holdable.axes[k].axes.leftCols(holdable.axes[k].count);
    const Mat3 spring = firm * axes * axes.transpose();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) entries.emplace_back(row + i, row + j, spring(i, j));
  }
}

}  // namespace

SparseMatrix rest_tangent(const Model& model) {
  std::vector<Eigen::Triplet<double>> entries;
  const std::vector<int>& free_index = model.system().free_index();
  for (const StrainDomain& domain : model.domains()) {
    const double mu = domain.shear_modulus, kappa = domain.bulk_modulus;
    for (std::size_t a = 0; a < domain.nodes.size(); ++a) {
      for (std::size_t b = 0; b <= a; ++b) {  // ascending: b's node is not above a's
        const int row = free_index[domain.nodes[a]], column = free_index[domain.nodes[b]];
        if (row < 0 || column < 0) continue;
        const Vec3 &ga = domain.gradients[a], &gb = domain.gradients[b];
        const Mat3 block = domain.volume * (mu * ga.dot(gb) * Mat3::Identity() + mu * gb * ga.transpose() +
                                            (kappa - 2.0 / 3.0 * mu) * ga * gb.transpose());
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k)
            if (row != column || i >= k) entries.emplace_back(3 * row + i, 3 * column + k, block(i, k));
      }
    }
  }
  add_support(model, entries);
  const int size = 3 * model.system().free_count();
  SparseMatrix lower(size, size);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

RestCompliance::RestCompliance(const Model& model)
    : observed_(3 * static_cast<int>(model.marker_points().size() + model.target_points().size())) {
  std::vector<int> pad_nodes;
  for (std::size_t pad = 0; pad < model.pad_nodes().size(); ++pad) {
    for (int node : spread_nodes(model, model.pad_nodes()[pad])) {
      for (int axis = 0; axis < 3; ++axis) {
        pad_of_.push_back(static_cast<int>(pad));
        row_of_.push_back(3 * model.system().free_index()[node] + axis);
      }
    }
  }
  const int size = 3 * model.system().free_count(), pads = static_cast<int>(pad_of_.size());
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(size, observed_ + pads);
  int column = 0;
  for (const auto* points : {&model.marker_points(), &model.target_points()})
    for (const MaterialPoint& point : *points) {
      put_point(model, point, column, right);
      column += 3;
    }
  for (int k = 0; k < pads; ++k) right(row_of_[k], observed_ + k) = 1.0;
  columns_ = RowMatrix::Zero(size, right.cols());
  if (right.size() > 0) columns_ = SparseCholesky(rest_tangent(model)).solve(right);
  const auto axes = 3 * static_cast<Eigen::Index>(model.pad_nodes().size());
  held_columns_ = RowMatrix::Zero(size, observed_ + axes);
  held_columns_.leftCols(observed_) = columns_.leftCols(observed_);
  pad_shift_ = RowMatrix::Zero(axes, observed_);
  reach_ = RowMatrix::Zero(pads, observed_ + axes);
  work_ = RowMatrix::Zero(size, pads);
  among_held_ = Eigen::MatrixXd::Zero(pads, pads);
  held_.reserve(pad_of_.size());
}

void RestCompliance::hold(std::span<const std::uint8_t> held_pads) {
  held_.clear();
  const auto is_held = [this](int row) {  // by another pad, that shares the node
    return std::any_of(held_.begin(), held_.end(), [&](int k) { return row_of_[k] == row; });
  };
  for (std::size_t k = 0; k < pad_of_.size(); ++k)
    if (held_pads[pad_of_[k]] && !is_held(row_of_[k])) held_.push_back(static_cast<int>(k));
  const int held = static_cast<int>(held_.size());
  held_columns_.leftCols(observed_) = columns_.leftCols(observed_);
  held_columns_.rightCols(pad_shift_.rows()).setZero();
  pad_shift_.setZero();
  if (held == 0) return;
  for (int k = 0; k < held; ++k) {
    for (int l = 0; l < held; ++l) among_held_(k, l) = columns_(row_of_[held_[k]], observed_ + held_[l]);
    reach_.row(k).head(observed_) = columns_.row(row_of_[held_[k]]).head(observed_);
    reach_.row(k).tail(pad_shift_.rows()).setZero();
    reach_(k, observed_ + axis_of(held_[k])) = -1.0;
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(among_held_.topLeftCorner(held, held));
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  const auto width = static_cast<int>(reach_.cols());
  forward_substitute(held, width, among_held_.data(), among_held_.outerStride(), reach_.data());
  backward_substitute(held, width, among_held_.data(), among_held_.outerStride(), reach_.data());
  for (int k = 0; k < held; ++k) pad_shift_.row(axis_of(held_[k])) += reach_.row(k).head(observed_);
  double* work = work_.data();
  for (Eigen::Index row = 0; row < columns_.rows(); ++row)
    for (int k = 0; k < held; ++k) *work++ = -columns_(row, observed_ + held_[k]);
  add_product(static_cast<int>(columns_.rows()), held, width, work_.data(), reach_.data(), held_columns_.data());
}

}  // namespace tissued::core
