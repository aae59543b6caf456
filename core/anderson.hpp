// Anderson acceleration (type II) of a fixed-point map p -> G(p), in a weighted norm.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tissued::core {

class Anderson {
 public:
  // weights: (size), of the norm in which the mixed residual is smallest.
  Anderson(Eigen::VectorXd weights, int depth);

  // Next iterate from the latest p, and G(p). With an empty history: G(p) itself.
  const Eigen::VectorXd& mix(const Eigen::VectorXd& p, const Eigen::VectorXd& mapped);
  void forget() {
    stored_ = next_ = 0;
    has_last_ = false;
  }
  // sqrt(sum w (G(p) - p)^2)
  double residual_norm(const Eigen::VectorXd& p, const Eigen::VectorXd& mapped) const;

 private:
  Eigen::VectorXd weights_;
  int depth_;
  int stored_ = 0;
  int next_ = 0;
  bool has_last_ = false;
  Eigen::MatrixXd mapped_steps_, residual_steps_;  // (size x depth)
  Eigen::VectorXd last_mapped_, last_residual_, residual_, mixed_;
};

}  // namespace tissued::core
