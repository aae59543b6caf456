#include "core/modal_covariance.hpp"

#include <Eigen/Cholesky>

#include "core/dense_kernels.hpp"

namespace tissued::core {

ModalCovariance::ModalCovariance(RowMatrix process_now, RowMatrix process_before, int largest_observation)
    : process_now_(std::move(process_now)),
      process_before_(std::move(process_before)),
      now_(RowMatrix::Zero(process_now_.rows(), process_now_.cols())),
      cross_(now_),
      before_(now_),
      y_now_(RowMatrix::Zero(largest_observation, now_.cols())),
      y_before_(y_now_),
      gain_now_(y_now_),
      gain_before_(y_now_),
      innovation_(Eigen::MatrixXd::Zero(largest_observation, largest_observation)) {}

void ModalCovariance::set_zero() {
  now_.setZero();
  cross_.setZero();
  before_.setZero();
}

void ModalCovariance::predict(const Eigen::VectorXd& a) {
  predict_covariance(modes(), a.data(), process_now_.data(), process_before_.data(), now_.data(), cross_.data(),
                     before_.data());
}

void ModalCovariance::update(const RowMatrix& h, const Eigen::VectorXd& variances, int m) {
  if (m == 0) return;
  const int r = modes();
  multiply(m, r, r, h.data(), now_.data(), y_now_.data());
  multiply(m, r, r, h.data(), cross_.data(), y_before_.data());
  auto s = innovation_.topLeftCorner(m, m);
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j <= i; ++j) s(i, j) = dot(r, y_now_.row(i).data(), h.row(j).data());
    s(i, i) += variances[i];
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(s);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  forward_substitute(m, r, innovation_.data(), innovation_.outerStride(), y_now_.data());
  forward_substitute(m, r, innovation_.data(), innovation_.outerStride(), y_before_.data());
  subtract_transposed_product(m, r, r, y_now_.data(), y_now_.data(), now_.data());
  subtract_transposed_product(m, r, r, y_now_.data(), y_before_.data(), cross_.data());
  subtract_transposed_product(m, r, r, y_before_.data(), y_before_.data(), before_.data());
  gain_now_.topRows(m) = y_now_.topRows(m);
  gain_before_.topRows(m) = y_before_.topRows(m);
  backward_substitute(m, r, innovation_.data(), innovation_.outerStride(), gain_now_.data());
  backward_substitute(m, r, innovation_.data(), innovation_.outerStride(), gain_before_.data());
}

}  // namespace tissued::core
