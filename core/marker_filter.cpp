#include "core/marker_filter.hpp"

#include <algorithm>
#include <cmath>

#include "core/dense_kernels.hpp"

namespace tissued::core {

namespace {

// mm^2 per axis: the paper's Q = 3I and R = 0.01 I.
constexpr double kPaperProcess = 3.0, kPaperMeasurement = 0.01;
// mm^2: the open-loop error of linear tetrahedra at the markers (shared reference: 0.7 to 1.5 mm).
constexpr double kForceProcess = 1.0;

RowMatrix rows_of(const std::vector<MaterialPoint>& points, const ModalBasis& basis,
                  const std::vector<int>& free_index) {
  RowMatrix rows = RowMatrix::Zero(static_cast<Eigen::Index>(points.size()), basis.modes());
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int a = 0; a < points[p].count; ++a)
      if (const int free = free_index[points[p].nodes[a]]; free >= 0)
        rows.row(static_cast<Eigen::Index>(p)) += points[p].weights[a] * basis.shapes.row(free);
  return rows;
}

RowMatrix rows_of(const HoldableNodes& holdable, const ModalBasis& basis, const std::vector<int>& free_index) {
  RowMatrix rows(holdable.count(), basis.modes());
  for (int k = 0; k < holdable.count(); ++k) rows.row(k) = basis.shapes.row(free_index[holdable.node[k]]);
  return rows;
}

// a_j of A = (M + dt^2 L)^-1 M with L of the plain weights k_i = kappa + 4/3 mu: by how much the solver scales its
// weights to converge is no statement about the tissue and must not change the estimate.
Eigen::VectorXd transition(const ModalBasis& basis, const Model& model) {
  const double dt = model.time_step();
  return (1.0 + dt * dt / model.weight_scale() * basis.lambda.array()).inverse();
}

// White body forces (force noise with covariance M) through the compliance of one step: Q_j = (dt^2 a_j)^2, smooth in
// space because stiff modes answer little.
Eigen::VectorXd force_shape(const Eigen::VectorXd& a, double dt) { return (dt * dt * a.array()).square(); }

// Stationary variance of q' = 2 a q - a q_before + w, var w = 1 (the AR(2) formula).
Eigen::ArrayXd stationary_gain(const Eigen::VectorXd& a) {
  return (1.0 + a.array()) / ((1.0 - a.array()).square() * (1.0 + 3.0 * a.array()));
}

// Mean over the markers of the stationary variance that modal noise of this shape gives when nothing is observed.
double marker_prior(const RowMatrix& marker_rows, const Eigen::VectorXd& a, const Eigen::VectorXd& shape) {
  if (marker_rows.rows() == 0) return 1.0;
  const Eigen::VectorXd variance = shape.array() * stationary_gain(a);
  return (marker_rows.cwiseAbs2() * variance).mean();
}

RowMatrix process_of(const Model& model, const ModalBasis& basis, const Eigen::VectorXd& a,
                     const RowMatrix& marker_rows, const FilterOptions& options) {
  if (options.preset == NoisePreset::paper) {
    const double size = options.process_noise > 0 ? options.process_noise : kPaperProcess;
    RowMatrix weighted = basis.shapes;  // M Phi
    for (Eigen::Index i = 0; i < weighted.rows(); ++i)
      weighted.row(i) *= model.masses()[model.system().free_nodes()[static_cast<std::size_t>(i)]];
    return size * (weighted.transpose() * weighted);
  }
  const double size = options.process_noise > 0 ? options.process_noise : kForceProcess;
  const Eigen::VectorXd shape = force_shape(a, model.time_step());
  return RowMatrix((size / marker_prior(marker_rows, a, shape) * shape).asDiagonal());
}

// In (15) the noise acts on both blocks of the state; physically the second block is a copy and has none.
RowMatrix process_before_of(const RowMatrix& process, const FilterOptions& options) {
  return options.preset == NoisePreset::paper ? process : RowMatrix::Zero(process.rows(), process.cols());
}

double measurement_of(const Model& model, const FilterOptions& options) {
  if (options.measurement_noise > 0) return options.measurement_noise * options.measurement_noise;
  if (options.preset == NoisePreset::paper) return kPaperMeasurement;
  return model.scene().marker_noise * model.scene().marker_noise;
}

}  // namespace

MarkerFilter::MarkerFilter(const Model& model, const ModalBasis& basis, const FilterOptions& options)
    : model_(model),
      basis_(basis),
      marker_variance_(measurement_of(model, options)),
      transition_(transition(basis, model)),
      marker_rows_(rows_of(model.marker_points(), basis, model.system().free_index())),
      pad_rows_(rows_of(model.holdable(), basis, model.system().free_index())),
      target_rows_(rows_of(model.target_points(), basis, model.system().free_index())),
      covariance_(process_of(model, basis, transition_, marker_rows_, options),
                  process_before_of(process_of(model, basis, transition_, marker_rows_, options), options),
                  static_cast<int>(marker_rows_.rows() + pad_rows_.rows())),
      initial_covariance_(covariance_) {
  const Eigen::Index largest = marker_rows_.rows() + pad_rows_.rows();
  const auto markers = static_cast<std::size_t>(marker_rows_.rows());
  pattern_.assign(markers + model.scene().pads.size(), 0);
  candidate_ = pattern_;
  used_markers_.reserve(markers);
  observed_ = RowMatrix::Zero(largest, basis_.modes());
  variances_ = Eigen::VectorXd::Zero(largest);
  last_gain_ = observed_;
  nodal_now_ = RowMatrix::Zero(basis_.shapes.rows(), marker_rows_.rows());
  nodal_before_ = nodal_now_;
  settled_target_variance_.assign(static_cast<std::size_t>(target_rows_.rows()), 0.0);
  innovation_.resize(markers);
  modal_now_.setZero(basis_.modes(), 4);
  modal_before_ = modal_now_;

  // Start from the steady state of all markers seen and no pad on the skin.
  const std::vector<std::uint8_t> all(markers, 1), none(model.scene().pads.size(), 0);
  choose_pattern(all, none);
  constexpr int kSettleLimit = 2000;  // steps; the slowest mode forgets with |eigenvalue|^2 = a_1 a step
  for (int step = 0; step < kSettleLimit && !settled_; ++step) advance_covariance(1);
  initial_covariance_ = covariance_;
  reset();
}

void MarkerFilter::reset() {
  covariance_ = initial_covariance_;
  // The pattern of nothing seen and nothing held, with the rows that belong to it.
  std::fill(pattern_.begin(), pattern_.end(), std::uint8_t{0});
  used_markers_.clear();
  rows_used_ = 0;
  last_gain_.setZero();
  settled_ = false;
}

void MarkerFilter::choose_pattern(std::span<const std::uint8_t> seen, std::span<const std::uint8_t> held_pads) {
  std::copy(seen.begin(), seen.end(), candidate_.begin());
  std::copy(held_pads.begin(), held_pads.end(), candidate_.begin() + static_cast<std::ptrdiff_t>(seen.size()));
  if (candidate_ == pattern_) return;
  pattern_ = candidate_;
  settled_ = false;
  last_gain_.setZero();
  used_markers_.clear();
  rows_used_ = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    used_markers_.push_back(static_cast<int>(i));
    observed_.row(rows_used_) = marker_rows_.row(static_cast<Eigen::Index>(i));
    variances_[rows_used_++] = marker_variance_;
  }
  for (int k = 0; k < model_.holdable().count(); ++k) {
    const auto group = static_cast<std::size_t>(model_.holdable().group[k]);
    if (group < held_pads.size() && !held_pads[group]) continue;  // beyond pads: the support
    observed_.row(rows_used_) = pad_rows_.row(k);
    variances_[rows_used_++] = kPadNoise * kPadNoise;
  }
}

void MarkerFilter::advance_covariance(int frames) {
  for (int k = 0; k < frames; ++k) covariance_.predict(transition_);
  if (rows_used_ == 0) return;
  covariance_.update(observed_, variances_, rows_used_);
  const auto gain = covariance_.gain_now().topRows(rows_used_);
  constexpr double kSettled = 1e-6;  // of the largest entry of the gain
  const double change = (gain - last_gain_.topRows(rows_used_)).cwiseAbs().maxCoeff();
  const bool quiet = frames == 1 && change <= kSettled * gain.cwiseAbs().maxCoeff();
  last_gain_.topRows(rows_used_) = gain;
  if (quiet) settle();
}

void MarkerFilter::settle() {
  settled_ = true;
  const int markers = static_cast<int>(used_markers_.size()), modes = basis_.modes();
  for (Eigen::Index node = 0; node < basis_.shapes.rows(); ++node) {
    for (int k = 0; k < markers; ++k) {
      nodal_now_(node, k) = dot(modes, basis_.shapes.row(node).data(), covariance_.gain_now().row(k).data());
      nodal_before_(node, k) = dot(modes, basis_.shapes.row(node).data(), covariance_.gain_before().row(k).data());
    }
  }
  settled_ = false;  // target_variance must look at the covariance itself once more
  for (std::size_t t = 0; t < settled_target_variance_.size(); ++t)
    settled_target_variance_[t] = target_variance(static_cast<int>(t));
  settled_ = true;
}

double MarkerFilter::target_variance(int target) const {
  if (settled_) return settled_target_variance_[static_cast<std::size_t>(target)];
  const int modes = basis_.modes();
  const double* row = target_rows_.row(target).data();
  double sum = 0.0;
  for (int i = 0; i < modes; ++i) sum += row[i] * dot(modes, covariance_.now().row(i).data(), row);
  return sum;
}

Innovation MarkerFilter::correct(std::span<const Vec3> markers, std::span<const std::uint8_t> seen,
                                 std::span<const std::uint8_t> held_pads, int frames, NodeField& x,
                                 NodeField& x_previous) {
  choose_pattern(seen, held_pads);
  if (!settled_ || frames != 1) {
    settled_ = false;
    advance_covariance(frames);
  }
  Innovation result;
  result.markers_used = static_cast<int>(used_markers_.size());
  if (used_markers_.empty()) return result;
  double sum = 0.0;
  for (std::size_t k = 0; k < used_markers_.size(); ++k) {
    const int i = used_markers_[k];
    const MaterialPoint& point = model_.marker_points()[i];
    // Displacements are compared: where exactly a marker was glued, or how long its stalk is, cancels.
    const Vec3 measured = markers[i] - model_.scene().markers[i].rest;
    const Vec3 predicted = position_of(point, x) - position_of(point, model_.rest());
    innovation_[k].head<3>() = measured - predicted;
    innovation_[k][3] = 0.0;
    sum += innovation_[k].squaredNorm();
  }
  result.rms = std::sqrt(sum / (3.0 * result.markers_used));
  if (settled_) {
    apply_nodal(x, x_previous);
  } else {
    apply_modal(x, x_previous);
  }
  return result;
}

void MarkerFilter::apply_nodal(NodeField& x, NodeField& x_previous) const {
  const int markers = static_cast<int>(used_markers_.size());
  const std::vector<int>& free = model_.system().free_nodes();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double* now = nodal_now_.row(static_cast<Eigen::Index>(i)).data();
    const double* before = nodal_before_.row(static_cast<Eigen::Index>(i)).data();
    Eigen::Vector4d move = Eigen::Vector4d::Zero(), move_before = Eigen::Vector4d::Zero();
    for (int k = 0; k < markers; ++k) {
      move += now[k] * innovation_[k];
      move_before += before[k] * innovation_[k];
    }
    x.row(free[i]) += move.transpose();
    x_previous.row(free[i]) += move_before.transpose();
  }
}

void MarkerFilter::apply_modal(NodeField& x, NodeField& x_previous) {
  modal_now_.setZero();
  modal_before_.setZero();
  for (std::size_t k = 0; k < used_markers_.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    for (int j = 0; j < basis_.modes(); ++j) {
      modal_now_.row(j) += covariance_.gain_now()(row, j) * innovation_[k].transpose();
      modal_before_.row(j) += covariance_.gain_before()(row, j) * innovation_[k].transpose();
    }
  }
  const std::vector<int>& free = model_.system().free_nodes();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double* shape = basis_.shapes.row(static_cast<Eigen::Index>(i)).data();
    Eigen::Vector4d move = Eigen::Vector4d::Zero(), move_before = Eigen::Vector4d::Zero();
    for (int j = 0; j < basis_.modes(); ++j) {
      move += shape[j] * modal_now_.row(j).transpose();
      move_before += shape[j] * modal_before_.row(j).transpose();
    }
    x.row(free[i]) += move.transpose();
    x_previous.row(free[i]) += move_before.transpose();
  }
}

}  // namespace tissued::core
