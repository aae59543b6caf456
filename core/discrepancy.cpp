#include "core/discrepancy.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/dense_kernels.hpp"

namespace tissued::core {

namespace {

constexpr double kSmallest = 1e-12;  // mm^2; keeps the factor definite where variance and uncertainty are none

RowMatrix kernel_of(const Scene& scene) {
  std::vector<Vec3> places;
  for (const Marker& marker : scene.markers) places.push_back(marker.rest);
  for (const Target& target : scene.targets) places.push_back(target.rest);
  RowMatrix kernel(static_cast<Eigen::Index>(scene.markers.size()), static_cast<Eigen::Index>(places.size()));
  const double scale = -0.5 / (Discrepancy::kLength * Discrepancy::kLength);
  for (Eigen::Index i = 0; i < kernel.rows(); ++i)
    for (Eigen::Index k = 0; k < kernel.cols(); ++k)
      kernel(i, k) =
          std::exp(scale * (places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(k)]).squaredNorm());
  return kernel;
}

std::vector<Mat3> planes_of_pads(const Scene& scene) {
  std::vector<Mat3> planes;
  for (const Pad& pad : scene.pads) {
    Vec3 area = Vec3::Zero();
    for (const Triangle& t : scene.mesh.find_surface(pad.surface)->triangles)
      area += (scene.mesh.node(t[1]) - scene.mesh.node(t[0])).cross(scene.mesh.node(t[2]) - scene.mesh.node(t[0]));
    const Vec3 normal = area.normalized();
    planes.push_back(Mat3::Identity() - normal * normal.transpose());
  }
  return planes;
}

}  // namespace

Discrepancy::Discrepancy(const Model& model, double noise_variance)
    : marker_count_(static_cast<int>(model.marker_points().size())),
      target_count_(static_cast<int>(model.target_points().size())),
      noise_variance_(noise_variance),
      kernel_(kernel_of(model.scene())),
      along_skin_(planes_of_pads(model.scene())),
      slip_of_(model.scene().pads.size(), -1) {
  const auto markers = static_cast<std::size_t>(marker_count_), targets = static_cast<std::size_t>(target_count_);
  const auto slips = static_cast<Eigen::Index>(3 * model.scene().pads.size());
  slip_rows_ = RowMatrix::Zero(3 * (marker_count_ + target_count_), slips);
  at_marker_.resize(markers);
  uncertainty_.resize(markers);
  slip_.resize(slips);
  at_target_.resize(targets);
  covariance_.resize(targets);
  known_.reserve(markers);
  kernel_factor_ = Eigen::MatrixXd::Zero(marker_count_, marker_count_);
  work_ = RowMatrix::Zero(marker_count_, 3 + target_count_ + 3 * slips);
  slip_factor_ = Eigen::MatrixXd::Zero(slips, slips);
  slip_work_ = RowMatrix::Zero(slips, 3);
  reset();
}

void Discrepancy::reset() {
  slips_ = 0;
  std::fill(slip_of_.begin(), slip_of_.end(), -1);
  std::fill(at_marker_.begin(), at_marker_.end(), Vec3::Zero());
  std::fill(uncertainty_.begin(), uncertainty_.end(), 0.0);
  std::fill(at_target_.begin(), at_target_.end(), Vec3::Zero());
  std::fill(covariance_.begin(), covariance_.end(), Mat3::Zero());
  slip_.setZero();
}

void Discrepancy::hold(const RestCompliance& compliance, std::span<const std::uint8_t> held_pads) {
  slips_ = 0;
  slip_.setZero();
  for (std::size_t pad = 0; pad < slip_of_.size(); ++pad) {
    slip_of_[pad] = -1;
    if (!held_pads[pad]) continue;
    slip_of_[pad] = slips_;
    const auto shift = compliance.pad_shift().middleRows(3 * static_cast<Eigen::Index>(pad), 3);
    slip_rows_.middleCols(slips_, 3).noalias() = shift.transpose() * along_skin_[pad];
    slips_ += 3;
  }
}

// A scalar Kalman filter for every marker, its three axes alike: b walks as the load does.
void Discrepancy::follow(std::span<const Vec3> innovation, std::span<const int> used, std::span<const double> moved,
                         double share, double load, double dt) {
  constexpr double kCreep = 0.05;    // mm per square root of a second, at rest
  constexpr double kSurprise = 9.0;  // of the squared innovation: it jumped
  for (std::size_t i = 0; i < uncertainty_.size(); ++i)
    uncertainty_[i] += share * share * load * moved[i] + kCreep * kCreep * dt;
  for (int marker : used) {
    const Vec3 news = innovation[marker] - at_marker_[marker];
    const double square = news.squaredNorm() / 3.0;
    double& uncertainty = uncertainty_[marker];
    if (square > kSurprise * (uncertainty + noise_variance_)) uncertainty = square;
    const double gain = uncertainty / (uncertainty + noise_variance_);
    at_marker_[marker] += gain * news;
    uncertainty *= 1.0 - gain;
  }
}

void Discrepancy::widen(double variance) {
  for (double& uncertainty : uncertainty_) uncertainty += variance;
}

// Gaussian process regression, its factor the same for all three axes, and with it the slips: their normal equations,
// whitened by that factor, couple the axes.
void Discrepancy::explain(double variance, double slip_variance) {
  known_.clear();
  for (int i = 0; i < marker_count_; ++i)
    if (uncertainty_[i] < variance + slip_variance) known_.push_back(i);
  if (!known_.empty()) fill_system(variance);
  find_slip(slip_variance);
  for (int target = 0; target < target_count_; ++target) explain_target(target, variance);
}

void Discrepancy::fill_system(double variance) {
  const int m = static_cast<int>(known_.size()), slips_begin = 3 + target_count_;
  for (int i = 0; i < m; ++i) {
    const int marker = known_[i];
    for (int j = 0; j <= i; ++j) kernel_factor_(i, j) = variance * kernel_(marker, known_[j]);
    kernel_factor_(i, i) += uncertainty_[marker] + kSmallest;
    work_.row(i).head<3>() = at_marker_[marker].transpose();
    for (int t = 0; t < target_count_; ++t) work_(i, 3 + t) = variance * kernel_(marker, marker_count_ + t);
    for (int axis = 0; axis < 3; ++axis)
      work_.row(i).segment(slips_begin + axis * slips_, slips_) = slip_rows_.row(3 * marker + axis).head(slips_);
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(kernel_factor_.topLeftCorner(m, m));
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  forward_substitute(m, static_cast<int>(work_.cols()), kernel_factor_.data(), kernel_factor_.outerStride(),
                     work_.data());
}

// Takes what the slips explain from the markers' b, whitened.
void Discrepancy::find_slip(double slip_variance) {
  const int m = static_cast<int>(known_.size()), slips_begin = 3 + target_count_;
  slip_.setZero();
  has_slip_ = slips_ > 0 && slip_variance > 0.0;
  if (!has_slip_) return;
  for (int k = 0; k < slips_; ++k) {
    for (int l = 0; l <= k; ++l) {
      double sum = k == l ? 1.0 / slip_variance : 0.0;
      for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < m; ++i)
          sum += work_(i, slips_begin + axis * slips_ + k) * work_(i, slips_begin + axis * slips_ + l);
      slip_factor_(k, l) = sum;
    }
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < m; ++i) slip_[k] += work_(i, slips_begin + axis * slips_ + k) * work_(i, axis);
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(slip_factor_.topLeftCorner(slips_, slips_));
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  forward_substitute(slips_, 1, slip_factor_.data(), slip_factor_.outerStride(), slip_.data());
  backward_substitute(slips_, 1, slip_factor_.data(), slip_factor_.outerStride(), slip_.data());
  for (int i = 0; i < m; ++i)
    for (int axis = 0; axis < 3; ++axis)
      work_(i, axis) -= dot(slips_, work_.row(i).data() + slips_begin + axis * slips_, slip_.data());
}

void Discrepancy::explain_target(int target, double variance) {
  const int m = static_cast<int>(known_.size()), slips_begin = 3 + target_count_;
  Vec3& shift = at_target_[target];
  shift.setZero();
  double known = 0.0;
  for (int i = 0; i < m; ++i) {
    const double weight = work_(i, 3 + target);
    shift += weight * work_.row(i).head<3>().transpose();
    known += weight * weight;
  }
  covariance_[target] = (variance - known) * Mat3::Identity();
  if (!has_slip_) return;
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = slip_rows_.row(3 * (marker_count_ + target) + axis);
    shift[axis] += dot(slips_, row.data(), slip_.data());
    for (int k = 0; k < slips_; ++k) {
      double left = row[k];
      for (int i = 0; i < m; ++i) left -= work_(i, 3 + target) * work_(i, slips_begin + axis * slips_ + k);
      slip_work_(k, axis) = left;
    }
  }
  forward_substitute(slips_, 3, slip_factor_.data(), slip_factor_.outerStride(), slip_work_.data());
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int k = 0; k < slips_; ++k) covariance_[target](a, b) += slip_work_(k, a) * slip_work_(k, b);
}

Vec3 Discrepancy::slip(int pad) const {
  const int first = slip_of_[static_cast<std::size_t>(pad)];
  return first < 0 ? Vec3::Zero() : Vec3(along_skin_[static_cast<std::size_t>(pad)] * slip_.segment<3>(first));
}

Vec3 Discrepancy::slip_at_marker(int marker) const {
  Vec3 moved;
  for (int axis = 0; axis < 3; ++axis)
    moved[axis] = dot(slips_, slip_rows_.row(3 * marker + axis).data(), slip_.data());
  return moved;
}

}  // namespace tissued::core
