#include "core/held_nodes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace tissued::core {

HoldableNodes::HoldableNodes(const SparseCholesky& factor, const std::vector<int>& free_index,
                             const std::vector<std::vector<int>>& groups)
    : group_count_(static_cast<int>(groups.size())) {
  const int free = factor.size();
  std::vector<int> row_of_free(static_cast<std::size_t>(free));
  for (int k = 0; k < free; ++k) row_of_free[factor.order()[k]] = k;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    for (int i : groups[g]) {
      if (free_index[i] < 0) continue;
      node.push_back(i);
      group.push_back(static_cast<int>(g));
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
      factor_(Eigen::MatrixXd::Zero(holdable.count(), holdable.count())),
      held_(static_cast<std::size_t>(holdable.count())),
      forces_(static_cast<std::size_t>(holdable.count()), Eigen::Vector4d::Zero()),
      increments_(static_cast<std::size_t>(holdable.count()), Eigen::Vector4d::Zero()),
      increment_rows_(static_cast<std::size_t>(4 * holdable.count())) {}

void HeldNodes::hold(std::span<const std::uint8_t> groups) {
  count_ = 0;
  for (int i = 0; i < holdable_->count(); ++i) {
    if (!groups[holdable_->group[i]]) {
      forces_[i].setZero();
      continue;
    }
    const auto same_node = [&](int other) { return holdable_->node[other] == holdable_->node[i]; };
    if (std::none_of(held_.begin(), held_.begin() + count_, same_node)) held_[count_++] = i;
  }
  if (count_ == 0) return;
  auto block = factor_.topLeftCorner(count_, count_);
  for (int i = 0; i < count_; ++i)
    for (int j = 0; j < count_; ++j) block(i, j) = holdable_->compliance(held_[i], held_[j]);
  Eigen::Ref<Eigen::MatrixXd> in_place(block);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
}

void HeldNodes::forget_forces() {
  for (Eigen::Vector4d& force : forces_) force.setZero();
}

void HeldNodes::add_forces(float* residual) const {
  for (int k = 0; k < count_; ++k)
    Eigen::Map<Eigen::Vector4f>(residual + 4 * static_cast<std::ptrdiff_t>(row(k))) += force(k).cast<float>();
}

void HeldNodes::enforce(float* delta, std::span<const Eigen::Vector4d> wanted) {
  if (count_ == 0) return;
  for (int k = 0; k < count_; ++k) {
    const float* moved = delta + 4 * static_cast<std::ptrdiff_t>(row(k));
    increments_[k] = wanted[k] - Eigen::Vector4d(moved[0], moved[1], moved[2], 0.0);
  }
  for (int i = 0; i < count_; ++i) {
    for (int j = 0; j < i; ++j) increments_[i] -= factor_(i, j) * increments_[j];
    increments_[i] /= factor_(i, i);
  }
  for (int i = count_ - 1; i >= 0; --i) {
    for (int j = i + 1; j < count_; ++j) increments_[i] -= factor_(j, i) * increments_[j];
    increments_[i] /= factor_(i, i);
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
