#include "core/anderson.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tissued::core {

Anderson::Anderson(Eigen::VectorXd weights, int depth)
    : weights_(std::move(weights)),
      depth_(depth),
      mapped_steps_(weights_.size(), depth),
      residual_steps_(weights_.size(), depth) {}

double Anderson::residual_norm(const Eigen::VectorXd& p, const Eigen::VectorXd& mapped) const {
  return std::sqrt(weights_.dot((mapped - p).cwiseAbs2()));
}

const Eigen::VectorXd& Anderson::mix(const Eigen::VectorXd& p, const Eigen::VectorXd& mapped) {
  residual_ = mapped - p;
  mixed_ = mapped;
  if (depth_ > 0 && has_last_) {
    mapped_steps_.col(next_) = mapped - last_mapped_;
    residual_steps_.col(next_) = residual_ - last_residual_;
    next_ = (next_ + 1) % depth_;
    stored_ = std::min(stored_ + 1, depth_);
    const auto steps = residual_steps_.leftCols(stored_);
    Eigen::MatrixXd gram = steps.transpose() * weights_.asDiagonal() * steps;
    // Steps that are nearly parallel must not be played against each other.
    gram.diagonal() *= 1.0 + 1e-10;
    const Eigen::VectorXd gamma = gram.ldlt().solve(steps.transpose() * weights_.cwiseProduct(residual_));
    if (gamma.allFinite()) mixed_ -= mapped_steps_.leftCols(stored_) * gamma;
  }
  last_mapped_ = mapped;
  last_residual_ = residual_;
  has_last_ = true;
  return mixed_;
}

}  // namespace tissued::core
