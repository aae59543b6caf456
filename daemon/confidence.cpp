#include "daemon/confidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tissued::daemon {
namespace {

Eigen::Matrix3d full_matrix(const std::array<double, 6>& covariance) {
  const auto& [xx, xy, xz, yy, yz, zz] = covariance;
  Eigen::Matrix3d matrix;
  matrix << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return matrix;
}

}  // namespace

std::optional<double> normalized_square(const core::Vec3& error, const std::array<double, 6>& covariance) {
  const Eigen::Matrix3d matrix = full_matrix(covariance);
  if (matrix.isZero(0.0)) return std::nullopt;
  return error.dot(matrix.ldlt().solve(error));
}

std::optional<double> radius_95(const std::array<double, 6>& covariance) {
  const Eigen::Matrix3d matrix = full_matrix(covariance);
  if (matrix.isZero(0.0)) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  return std::sqrt(kChiSquare95 * std::max(0.0, solver.eigenvalues().maxCoeff()));
}

std::optional<double> error_of(const protocol::TargetPrediction& prediction) {
  if (!prediction.has_truth) return std::nullopt;
  return std::hypot(prediction.position[0] - prediction.truth[0], prediction.position[1] - prediction.truth[1],
                    prediction.position[2] - prediction.truth[2]);
}

std::optional<bool> inside_95(const protocol::TargetPrediction& prediction) {
  if (!prediction.has_truth) return std::nullopt;
  const core::Vec3 error(prediction.position[0] - prediction.truth[0], prediction.position[1] - prediction.truth[1],
                         prediction.position[2] - prediction.truth[2]);
  const auto square = normalized_square(error, prediction.covariance);
  if (!square) return std::nullopt;
  return *square <= kChiSquare95;
}

std::vector<std::string> reason_names(std::uint16_t reasons) {
  std::vector<std::string> names;
  for (unsigned bit = 0; bit < 16; ++bit) {
    if ((reasons >> bit & 1) != 0) names.emplace_back(protocol::validity_reason_name(bit));
  }
  return names;
}

}  // namespace tissued::daemon
