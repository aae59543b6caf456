#include "core/rest_calibration.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace tissued::core {

Registration register_rigid(std::span<const Vec3> from, std::span<const Vec3> to) {
  Registration result;
  result.points = static_cast<int>(from.size());
  if (from.empty()) return result;
  Vec3 from_mean = Vec3::Zero(), to_mean = Vec3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i];
    to_mean += to[i];
  }
  from_mean /= static_cast<double>(from.size());
  to_mean /= static_cast<double>(from.size());
  Mat3 cross = Mat3::Zero(), spread = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    cross += (to[i] - to_mean) * (from[i] - from_mean).transpose();
    spread += (from[i] - from_mean) * (from[i] - from_mean).transpose();
  }
  const Eigen::JacobiSVD<Mat3> spread_svd(spread);
  // Points on a line leave the rotation about it free.
  result.determined = from.size() >= 3 && spread_svd.singularValues()[1] > 1e-8 * spread_svd.singularValues()[0];
  if (result.determined) {
    const Eigen::JacobiSVD<Mat3> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vec3 sign(1, 1, svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1.0 : 1.0);
    result.tissue_from_tracker.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  }
  result.tissue_from_tracker.translation = to_mean - result.tissue_from_tracker.rotation * from_mean;
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double squared = (result.tissue_from_tracker(from[i]) - to[i]).squaredNorm();
    sum += squared;
    result.residual_max = std::max(result.residual_max, std::sqrt(squared));
  }
  result.residual_rms = std::sqrt(sum / static_cast<double>(from.size()));
  return result;
}

RestCalibration::RestCalibration(std::vector<Vec3> rest, double placement_sd, double noise_sd, RigidTransform initial,
                                 bool fit_rigid)
    : rest_(std::move(rest)),
      placement_variance_(placement_sd * placement_sd),
      noise_variance_(noise_sd * noise_sd),
      initial_(initial),
      fit_rigid_(fit_rigid) {
  sums_.resize(rest_.size());
  counts_.resize(rest_.size());
  offsets_.resize(rest_.size());
  from_.reserve(rest_.size());
  to_.reserve(rest_.size());
  reset();
}

void RestCalibration::reset() {
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    sums_[i].setZero();
    offsets_[i].setZero();
    counts_[i] = 0;
  }
  frames_ = 0;
  registration_ = Registration{};
  registration_.tissue_from_tracker = initial_;
}

void RestCalibration::add(std::span<const Vec3> markers, std::span<const std::uint8_t> seen) {
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (!seen[i]) continue;
    sums_[i] += markers[i];
    ++counts_[i];
  }
  ++frames_;
  refit();
}

void RestCalibration::refit() {
  from_.clear();
  to_.clear();
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (counts_[i] == 0) continue;
    from_.push_back(sums_[i] / counts_[i]);
    to_.push_back(rest_[i]);
  }
  if (fit_rigid_) {
    Registration fitted = register_rigid(from_, to_);
    if (fitted.determined) {
      registration_ = fitted;
    } else {
      registration_.points = fitted.points;
      registration_.determined = false;
    }
  }
  const RigidTransform& t = registration_.tissue_from_tracker;
  double sum = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (counts_[i] == 0) continue;
    const Vec3 difference = t(sums_[i] / counts_[i]) - rest_[i];
    offsets_[i] = difference * (placement_variance_ / (placement_variance_ + noise_variance_ / counts_[i]));
    sum += difference.squaredNorm();
    largest = std::max(largest, difference.norm());
  }
  registration_.points = static_cast<int>(from_.size());
  if (!from_.empty()) registration_.residual_rms = std::sqrt(sum / static_cast<double>(from_.size()));
  registration_.residual_max = largest;
}

Vec3 RestCalibration::to_model(int marker, const Vec3& tracker_position) const {
  return registration_.tissue_from_tracker(tracker_position) - offsets_[marker];
}

double RestCalibration::place_sd() const {
  if (placement_variance_ <= 0.0 || frames_ == 0) return std::sqrt(placement_variance_);
  if (noise_variance_ <= 0.0) return 0.0;
  return 1.0 / std::sqrt(1.0 / placement_variance_ + frames_ / noise_variance_);
}

}  // namespace tissued::core
