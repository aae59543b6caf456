#include "core/held_nodes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace tissued::core {

HoldableNodes::HoldableNodes(const SparseCholesky& factor, const std::vector<int>& free_index,
                             const std::vector<std::vector<int>>& groups,
                             const std::vector<std::vector<HeldAxes>>& group_axes)
    : group_count_(static_cast<int>(groups.size())) {
  const int free = factor.size();
  std::vector<int> row_of_free(static_cast<std::size_t>(free));
  for (int k = 0; k < free; ++k) row_of_free[factor.order()[k]] = k;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (std::size_t k = 0; k < groups[g].size(); ++k) {
      const int i = groups[g][k];
      const HeldAxes held = group_axes.empty() || group_axes[g].empty() ? HeldAxes{} : group_axes[g][k];
      if (free_index[i] < 0 || held.count == 0) continue;
      node.push_back(i);
      group.push_back(static_cast<int>(g));
      axes.push_back(held);
      slides_ = slides_ || held.count < 3;
      row.push_back(row_of_free[free_index[i]]);
    }
  }
  columns.resize(static_cast<std::size_t>(free) * node.size());
  compliance.resize(count(), count());
  constexpr int kChunk = 64;  // right-hand sides a solve: bounds the memory on large meshes
  for (int begin = 0; begin < count(); begin += kChunk) {
    const int width = std::min(kChunk, count() - begin);
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(free, width);
    for (int j = 0; j < width; ++j) unit(free_index[node[begin + j]], j) = 1.0;
    const Eigen::MatrixXd answer = factor.solve(unit);
    for (int j = 0; j < width; ++j) {
      for (int k = 0; k < free; ++k)
        columns[static_cast<std::size_t>(k) * node.size() + begin + j] =
            static_cast<float>(answer(factor.order()[k], j));
      for (int i = 0; i < count(); ++i) compliance(i, begin + j) = answer(free_index[node[i]], j);
    }
  }
}

HeldNodes::HeldNodes(const HoldableNodes& holdable)
    : holdable_(&holdable),
      factor_(Eigen::MatrixXd::Zero((holdable.slides() ? 3 : 1) * holdable.count(),
                                    (holdable.slides() ? 3 : 1) * holdable.count())),
      held_(static_cast<std::size_t>(holdable.count())),
      forces_(static_cast<std::size_t>(holdable.count()), Eigen::Vector4d::Zero()),
      increments_(static_cast<std::size_t>(holdable.count()), Eigen::Vector4d::Zero()),
      increment_rows_(static_cast<std::size_t>(4 * holdable.count())),
      multipliers_(factor_.rows()) {
  constraints_.reserve(static_cast<std::size_t>(factor_.rows()));
  first_constraint_.reserve(held_.size() + 1);
}

void HeldNodes::hold(std::span<const std::uint8_t> groups, std::span<const Mat3> rotations) {
  count_ = 0;
  for (int i = 0; i < holdable_->count(); ++i) {
    if (!groups[holdable_->group[i]]) {
      forces_[i].setZero();
      continue;
    }
    const auto same_node = [&](int other) { return holdable_->node[other] == holdable_->node[i]; };
    if (std::none_of(held_.begin(), held_.begin() + count_, same_node)) held_[count_++] = i;
  }
  constraints_.clear();
  first_constraint_.assign(1, 0);
  if (count_ == 0) return;
  if (holdable_->slides()) {
    for (int k = 0; k < count_; ++k) {
      const HeldAxes& held = holdable_->axes[held_[k]];
      const Mat3 axes = rotations.empty() ? held.axes : Mat3(rotations[group(k)] * held.axes);
      for (int axis = 0; axis < held.count; ++axis) constraints_.push_back({k, axes.col(axis)});
      first_constraint_.push_back(static_cast<int>(constraints_.size()));
    }
  }
  const int size = holdable_->slides() ? static_cast<int>(constraints_.size()) : count_;
  auto block = factor_.topLeftCorner(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) {
      if (!holdable_->slides()) {
        block(i, j) = holdable_->compliance(held_[i], held_[j]);
        continue;
      }
      const Constraint &a = constraints_[i], &b = constraints_[j];
      block(i, j) = holdable_->compliance(held_[a.k], held_[b.k]) * a.axis.dot(b.axis);
    }
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(block);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
}

Eigen::Vector4d HeldNodes::level(int k, const Eigen::Vector4d& from, const Eigen::Vector4d& to) const {
  if (!holdable_->slides()) return to;
  Eigen::Vector4d at = from;
  for (int c = first_constraint_[k]; c < first_constraint_[k + 1]; ++c)
    at.head<3>() += constraints_[c].axis * constraints_[c].axis.dot((to - from).head<3>());
  return at;
}

void HeldNodes::resist(std::span<const int> rows, std::span<const double> weights,
                       Eigen::Ref<Eigen::VectorXd> out) const {
  out.setZero();
  for (std::size_t a = 0; a < rows.size(); ++a) {
    if (rows[a] < 0) continue;
    const float* column = holdable_->columns.data() + static_cast<std::size_t>(rows[a]) * holdable_->node.size();
    for (int k = 0; k < count_; ++k) out[k] += weights[a] * static_cast<double>(column[held_[k]]);
  }
  for (int i = 0; i < count_; ++i) {
    for (int j = 0; j < i; ++j) out[i] -= factor_(i, j) * out[j];
    out[i] /= factor_(i, i);
  }
}

void HeldNodes::forget_forces() {
  for (Eigen::Vector4d& force : forces_) force.setZero();
}

void HeldNodes::add_forces(float* residual) const {
  for (int k = 0; k < count_; ++k)
    Eigen::Map<Eigen::Vector4f>(residual + 4 * static_cast<std::ptrdiff_t>(row(k))) += force(k).cast<float>();
}

// Of increments_: from how far the nodes must still move to the forces along their axes that move them.
void HeldNodes::solve_constraints() {
  const auto size = static_cast<Eigen::Index>(constraints_.size());
  for (Eigen::Index c = 0; c < size; ++c)
    multipliers_[c] = constraints_[c].axis.dot(increments_[constraints_[c].k].head<3>());
  const auto lower = factor_.topLeftCorner(size, size).triangularView<Eigen::Lower>();
  auto multipliers = multipliers_.head(size);
  lower.solveInPlace(multipliers);
  lower.transpose().solveInPlace(multipliers);
  for (int k = 0; k < count_; ++k) increments_[k].setZero();
  for (Eigen::Index c = 0; c < size; ++c)
    increments_[constraints_[c].k].head<3>() += multipliers[c] * constraints_[c].axis;
}

void HeldNodes::enforce(float* delta, std::span<const Eigen::Vector4d> wanted) {
  if (count_ == 0) return;
  for (int k = 0; k < count_; ++k) {
    const float* moved = delta + 4 * static_cast<std::ptrdiff_t>(row(k));
    increments_[k] = wanted[k] - Eigen::Vector4d(moved[0], moved[1], moved[2], 0.0);
  }
  if (holdable_->slides()) {
    solve_constraints();
  } else {
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j < i; ++j) increments_[i] -= factor_(i, j) * increments_[j];
      increments_[i] /= factor_(i, i);
    }
    for (int i = count_ - 1; i >= 0; --i) {
      for (int j = i + 1; j < count_; ++j) increments_[i] -= factor_(j, i) * increments_[j];
      increments_[i] /= factor_(i, i);
    }
  }
  for (int k = 0; k < count_; ++k) {
    forces_[held_[k]] += increments_[k];
    Eigen::Map<Eigen::Vector4f>(increment_rows_.data() + 4 * k) = increments_[k].cast<float>();
  }
  const std::size_t stride = holdable_->node.size();
  const auto free = static_cast<std::ptrdiff_t>(holdable_->columns.size() / stride);
  for (std::ptrdiff_t i = 0; i < free; ++i) {
    const float* column = holdable_->columns.data() + static_cast<std::size_t>(i) * stride;
    Eigen::Map<Eigen::Vector4f> move(delta + 4 * i);
    Eigen::Vector4f sum = move;
    for (int k = 0; k < count_; ++k)
      sum += column[held_[k]] * Eigen::Map<const Eigen::Vector4f>(increment_rows_.data() + 4 * k);
    move = sum;
  }
}

}  // namespace tissued::core
