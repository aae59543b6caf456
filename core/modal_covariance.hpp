// The covariance of the Kalman filter's state [q_n; q_{n-1}] in modal coordinates, equations (16) and (17). One axis:
// with isotropic noise the three axes share it.
#pragma once

#include <Eigen/Core>

namespace tissued::core {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class ModalCovariance {
 public:
  // Q of (15): added to the block of q_n and to that of q_{n-1}; (r x r), mm^2 kg in modal coordinates.
  ModalCovariance(RowMatrix process_now, RowMatrix process_before, int largest_observation);

  int modes() const { return static_cast<int>(now_.rows()); }
  void set_zero();
  // (16), second line, with S = [2A, -A; I, 0] and A = diag(a): elementwise.
  void predict(const Eigen::VectorXd& a);
  // (17): observes rows of h (m x r) of q_n with independent noise of the given variances (m). Leaves the gains.
  void update(const RowMatrix& h, const Eigen::VectorXd& variances, int m);

  // S^-1 Y of the last update, (m x r) each: K^T of the two blocks.
  const RowMatrix& gain_now() const { return gain_now_; }
  const RowMatrix& gain_before() const { return gain_before_; }
  // Covariance blocks, (r x r) row-major: now-now, now-before, before-before.
  const RowMatrix& now() const { return now_; }
  const RowMatrix& cross() const { return cross_; }
  const RowMatrix& before() const { return before_; }

 private:
  RowMatrix process_now_, process_before_;
  RowMatrix now_, cross_, before_;
  RowMatrix y_now_, y_before_;  // (largest m x r): H P, later L^-1 H P
  RowMatrix gain_now_, gain_before_;
  Eigen::MatrixXd innovation_;  // (largest m x largest m)
};

}  // namespace tissued::core
