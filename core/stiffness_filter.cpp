#include "core/stiffness_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/dense_kernels.hpp"
#include "core/neo_hookean.hpp"
#include "core/stiffness_field.hpp"

namespace tissued::core {

namespace {

constexpr int kMostCoefficients = 128;
constexpr double kLargestLogStiffness = 1.1;  // a factor of 3: beyond, the ADMM weights no longer hold the element
// Learning: when markers that have travelled so far have come to rest. In motion, what lags is not the stiffness.
constexpr double kTravel = 0.5, kStill = 0.1, kLeastLoad = 1.0;  // mm
constexpr double kRestTime = 0.2;                                // s
constexpr double kUnloading = 0.9;  // of the largest load since rest: what it says was said before
// A discrepancy is one and the same over so much travel; learning from less of it counts less.
constexpr double kFreshTravel = 5.0;    // mm
constexpr double kForgetting = 0.01;    // share of what is known that a learning step gives back: the body may change
constexpr double kGate = 25.0;          // of the squared innovation in units of its covariance: 5 standard deviations
constexpr double kUnlearntShare = 0.1;  // of the load: what may be off before anything was learnt

RowMatrix kernel_of(const Model& model) {
  std::vector<Vec3> places;
  for (const Marker& marker : model.scene().markers) places.push_back(marker.rest);
  for (const Target& target : model.scene().targets) places.push_back(target.rest);
  const auto markers = static_cast<Eigen::Index>(model.scene().markers.size());
  RowMatrix kernel(markers, static_cast<Eigen::Index>(places.size()));
  const double scale = -0.5 / (StiffnessFilter::kLengthOfDiscrepancy * StiffnessFilter::kLengthOfDiscrepancy);
  for (Eigen::Index i = 0; i < kernel.rows(); ++i)
    for (Eigen::Index k = 0; k < kernel.cols(); ++k)
      kernel(i, k) =
          std::exp(scale * (places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(k)]).squaredNorm());
  return kernel;
}

double largest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (a[i] - b[i]).squaredNorm());
  return std::sqrt(largest);
}

}  // namespace

StiffnessFilter::StiffnessFilter(const Model& model, const FilterOptions& options)
    : model_(&model),
      compliance_(model),
      marker_count_(static_cast<int>(model.marker_points().size())),
      target_count_(static_cast<int>(model.target_points().size())),
      field_(
          stiffness_field(model.scene().mesh.rest, options.stiffness_sd, options.stiffness_length, kMostCoefficients)),
      kernel_(kernel_of(model)),
      noise_variance_(
          std::pow(options.measurement_noise > 0 ? options.measurement_noise : model.scene().marker_noise, 2)),
      initial_share_(options.discrepancy) {
  const auto markers = static_cast<std::size_t>(marker_count_), targets = static_cast<std::size_t>(target_count_);
  const Eigen::Index r = field_.cols(), m = marker_count_, observed = compliance_.observed();
  displacement_.assign(markers, Vec3::Zero());
  innovation_.assign(markers, Vec3::Zero());
  used_.reserve(markers);
  refused_.reserve(markers);
  known_.reserve(markers);
  squares_.reserve(markers);
  target_shift_.assign(targets, Vec3::Zero());
  learnt_covariance_.assign(markers + targets, Mat3::Zero());
  target_covariance_.assign(targets, Mat3::Zero());
  domain_row_ = RowMatrix::Zero(1, observed);
  at_nodes_ = RowMatrix::Zero(field_.rows(), observed);
  std::size_t corners = 0;
  for (const StrainDomain& domain : model.domains()) corners = std::max(corners, domain.nodes.size());
  corner_factors_.reserve(3 * corners);
  corner_rows_.reserve(3 * corners);
  sensitivity_ = RowMatrix::Zero(observed, r);
  rows_ = RowMatrix::Zero(3 * m, r);
  spread_rows_ = rows_;
  gain_ = rows_;
  spread_ = Eigen::MatrixXd::Zero(3 * m, 3 * m);
  kernel_factor_ = Eigen::MatrixXd::Zero(m, m);
  kernel_work_ = RowMatrix::Zero(m, 3 + target_count_);
  log_stiffness_ = Eigen::VectorXd::Zero(field_.rows());
  covariance_ = RowMatrix::Identity(r, r);
  coefficients_ = Eigen::VectorXd::Zero(r);
  reset();
}

void StiffnessFilter::reset() {
  coefficients_.setZero();
  log_stiffness_.setZero();
  covariance_.setIdentity();
  sensitivity_.setZero();
  share_ = initial_share_;
  learnt_ = false;
  const auto markers = static_cast<std::size_t>(marker_count_);
  learnt_at_.assign(markers, Vec3::Zero());
  discrepancy_.assign(markers, Vec3::Zero());
  displacement_before_.assign(markers, Vec3::Zero());
  uncertainty_.assign(markers, 0.0);
  resting_at_.assign(markers, Vec3::Zero());
  next_domain_ = 0;
  resting_ = load_ = travel_ = peak_load_ = sensitivity_load_ = 0.0;
  held_.assign(model_->scene().pads.size(), 0);
  compliance_.hold(held_);
  std::fill(target_shift_.begin(), target_shift_.end(), Vec3::Zero());
  std::fill(learnt_covariance_.begin(), learnt_covariance_.end(), Mat3::Zero());
  std::fill(target_covariance_.begin(), target_covariance_.end(), Mat3::Zero());
  update_covariances();
}

Innovation StiffnessFilter::correct(std::span<const Vec3> markers, std::span<const std::uint8_t> seen,
                                    std::span<const std::uint8_t> held_pads, double dt, AdmmState& state) {
  if (!std::equal(held_pads.begin(), held_pads.end(), held_.begin())) {
    std::copy(held_pads.begin(), held_pads.end(), held_.begin());
    compliance_.hold(held_);
  }
  measure(markers, seen, state);
  variance_ = std::max(expected_variance(), shown_variance());
  gate(markers);
  Innovation result;
  result.markers_used = static_cast<int>(used_.size());
  result.markers_swapped = swapped_;
  double sum = 0.0;
  for (int marker : used_) sum += innovation_[marker].squaredNorm();
  if (!used_.empty()) result.rms = std::sqrt(sum / (3.0 * result.markers_used));
  follow_discrepancy(dt);
  if (load_is_news(dt) && !used_.empty()) {
    learn_in_parts(state);
  } else {
    next_domain_ = 0;
  }
  spread_discrepancy();
  update_covariances();
  return result;
}

// Innovations of the markers seen, against the simulation; displacements are compared: where exactly a marker was glued
// cancels.
void StiffnessFilter::measure(std::span<const Vec3> markers, std::span<const std::uint8_t> seen,
                              const AdmmState& state) {
  used_.clear();
  load_ = 0.0;
  for (int i = 0; i < marker_count_; ++i) {
    const MaterialPoint& point = model_->marker_points()[i];
    displacement_[i] = position_of(point, state.x) - position_of(point, model_->rest());
    load_ = std::max(load_, displacement_[i].norm());
    if (!seen[i]) continue;
    innovation_[i] = markers[i] - model_->scene().markers[i].rest - displacement_[i];
    used_.push_back(i);
  }
}

// mm^2 per axis, from the median of the squared innovations, which a few wild markers do not move.
double StiffnessFilter::shown_variance() {
  constexpr double kMedian = 2.366;  // of chi square with 3 degrees of freedom
  constexpr std::size_t kFewest = 4;
  if (used_.size() < kFewest) return 0.0;
  squares_.clear();
  for (int marker : used_) squares_.push_back(innovation_[marker].squaredNorm());
  const auto middle = squares_.begin() + static_cast<std::ptrdiff_t>(squares_.size() / 2);
  std::nth_element(squares_.begin(), middle, squares_.end());
  return std::max(0.0, *middle / kMedian - noise_variance_);
}

bool StiffnessFilter::plausible(int marker, const Vec3& innovation) const {
  const double unlearnt = learnt_ ? 0.0 : kUnlearntShare * load_;
  Mat3 covariance = learnt_covariance_[marker];
  covariance.diagonal().array() += variance_ + unlearnt * unlearnt + noise_variance_;
  return innovation.dot(covariance.inverse() * innovation) <= kGate;
}

// Refuses single markers that no model of this accuracy puts there. Where most would be refused it is the model that is
// wrong, and they are kept.
void StiffnessFilter::gate(std::span<const Vec3> markers) {
  refused_.clear();
  swapped_ = 0;
  for (int marker : used_)
    if (!plausible(marker, innovation_[marker])) refused_.push_back(marker);
  if (2 * refused_.size() > used_.size()) return;
  for (std::size_t k = 0; k < refused_.size();)
    if (!unswap(k, markers)) ++k;
  for (int marker : refused_) used_.erase(std::find(used_.begin(), used_.end(), marker));
}

// Two refused markers that fit where the other should be carry each other's label.
bool StiffnessFilter::unswap(std::size_t first, std::span<const Vec3> markers) {
  const int a = refused_[first];
  for (std::size_t second = first + 1; second < refused_.size(); ++second) {
    const int b = refused_[second];
    const Vec3 at_a = markers[b] - model_->scene().markers[a].rest - displacement_[a];
    const Vec3 at_b = markers[a] - model_->scene().markers[b].rest - displacement_[b];
    if (!plausible(a, at_a) || !plausible(b, at_b)) continue;
    innovation_[a] = at_a;
    innovation_[b] = at_b;
    swapped_ += 2;
    refused_.erase(refused_.begin() + static_cast<std::ptrdiff_t>(second));
    refused_.erase(refused_.begin() + static_cast<std::ptrdiff_t>(first));
    return true;
  }
  return false;
}

// A scalar Kalman filter for every marker, its three axes alike: the discrepancy walks as the load does.
void StiffnessFilter::follow_discrepancy(double dt) {
  constexpr double kCreep = 0.05;    // mm per square root of a second, at rest
  constexpr double kSurprise = 9.0;  // of the squared innovation: it jumped
  for (int i = 0; i < marker_count_; ++i) {
    const double moved = (displacement_[i] - displacement_before_[i]).norm();
    displacement_before_[i] = displacement_[i];
    uncertainty_[i] += share_ * share_ * load_ * moved + kCreep * kCreep * dt;
  }
  for (int marker : used_) {
    const Vec3 news = innovation_[marker] - discrepancy_[marker];
    const double square = news.squaredNorm() / 3.0;
    double& uncertainty = uncertainty_[marker];
    if (square > kSurprise * (uncertainty + noise_variance_)) uncertainty = square;
    const double gain = uncertainty / (uncertainty + noise_variance_);
    discrepancy_[marker] += gain * news;
    uncertainty *= 1.0 - gain;
  }
}

// Whether the load is at rest and says something that it did not say before.
bool StiffnessFilter::load_is_news(double dt) {
  travel_ = largest_distance(displacement_, learnt_at_);
  if (largest_distance(displacement_, resting_at_) > kStill) {
    resting_at_ = displacement_;
    resting_ = 0.0;
  } else {
    resting_ += dt;
  }
  if (load_ < kLeastLoad) peak_load_ = 0.0;
  if (resting_ < kRestTime || travel_ < kTravel || load_ < kLeastLoad) return false;
  if (load_ >= kUnloading * peak_load_) return true;
  learnt_at_ = displacement_;
  return false;
}

// The sensitivities of all domains at once would cost a frame more than its share; at rest nothing is lost by waiting.
void StiffnessFilter::learn_in_parts(AdmmState& state) {
  constexpr std::size_t kDomainsPerFrame = 500;
  const std::size_t domains = model_->domains().size();
  if (next_domain_ < domains) {
    if (next_domain_ == 0) at_nodes_.setZero();
    const std::size_t last = std::min(next_domain_ + kDomainsPerFrame, domains);
    for (; next_domain_ < last; ++next_domain_) add_sensitivity(model_->domains()[next_domain_], state);
    if (next_domain_ == domains) finish_sensitivity();
    return;
  }
  learn();
  apply(state);
  next_domain_ = 0;
  learnt_at_ = displacement_;
  peak_load_ = std::max(peak_load_, load_);
}

// By the log-stiffness of a domain's anchors: compliance x the forces of its stress.
void StiffnessFilter::add_sensitivity(const StrainDomain& domain, const AdmmState& state) {
  Mat3 f = Mat3::Zero();
  for (std::size_t a = 0; a < domain.nodes.size(); ++a)
    f += state.x.row(domain.nodes[a]).head<3>().transpose() * domain.gradients[a].transpose();
  if (!(f.determinant() > 0.0)) return;
  double log_stiffness = 0.0;
  for (int anchor : domain.anchors) log_stiffness += log_stiffness_[anchor];
  const auto anchors = static_cast<double>(domain.anchors.size());
  const Mat3 stress = domain.volume * std::exp(log_stiffness / anchors) / anchors *
                      first_piola(domain.shear_modulus, domain.bulk_modulus, f);
  corner_factors_.clear();
  corner_rows_.clear();
  for (std::size_t a = 0; a < domain.nodes.size(); ++a) {
    const int free = model_->system().free_index()[domain.nodes[a]];
    if (free < 0) continue;
    const Vec3 force = stress * domain.gradients[a];
    for (int axis = 0; axis < 3; ++axis) {
      corner_factors_.push_back(force[axis]);
      corner_rows_.push_back(3 * free + axis);
    }
  }
  domain_row_.setZero();
  add_rows(compliance_.observed(), static_cast<int>(corner_rows_.size()), corner_rows_.data(), corner_factors_.data(),
           compliance_.columns().data(), domain_row_.data());
  for (int anchor : domain.anchors) at_nodes_.row(anchor) += domain_row_.row(0);
}

// J: a stiffer element holds what its stress pushed, hence the sign.
void StiffnessFilter::finish_sensitivity() {
  sensitivity_.setZero();
  subtract_transposed_product(static_cast<int>(at_nodes_.rows()), compliance_.observed(),
                              static_cast<int>(field_.cols()), at_nodes_.data(), field_.data(), sensitivity_.data());
  sensitivity_load_ = load_;
}

// Kalman update of the coefficients from the innovations of the markers used.
void StiffnessFilter::learn() {
  const int m = 3 * static_cast<int>(used_.size()), r = static_cast<int>(field_.cols());
  covariance_ *= 1.0 - kForgetting;
  covariance_.diagonal().array() += kForgetting;
  for (std::size_t k = 0; k < used_.size(); ++k)
    rows_.middleRows(3 * static_cast<Eigen::Index>(k), 3) = sensitivity_.middleRows(3 * used_[k], 3);
  multiply(m, r, r, rows_.data(), covariance_.data(), spread_rows_.data());
  const double share_of_news = std::max(1.0, kFreshTravel / travel_);
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j <= i; ++j) {
      double s = dot(r, spread_rows_.row(i).data(), rows_.row(j).data());
      if (i % 3 == j % 3) s += share_of_news * expected_variance() * kernel_(used_[i / 3], used_[j / 3]);
      if (i == j) s += uncertainty_[used_[i / 3]];
      spread_(i, j) = s;
    }
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(spread_.topLeftCorner(m, m));
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  forward_substitute(m, r, spread_.data(), spread_.outerStride(), spread_rows_.data());
  // gain_'s first column: L^-1 innovation.
  double square = 0.0;
  for (int i = 0; i < m; ++i) {
    double value = discrepancy_[used_[i / 3]][i % 3];
    for (int k = 0; k < i; ++k) value -= spread_(i, k) * gain_(k, 0);
    gain_(i, 0) = value / spread_(i, i);
    square += gain_(i, 0) * gain_(i, 0);
  }
  for (int i = 0; i < m; ++i) coefficients_ += gain_(i, 0) * spread_rows_.row(i).transpose();
  subtract_transposed_product(m, r, r, spread_rows_.data(), spread_rows_.data(), covariance_.data());
  // How large the discrepancy is, innovations say: their mean square in units of their covariance ought to be 1.
  constexpr double kRate = 0.1, kNarrowest = 0.5, kWidest = 3.0;
  const double ratio = std::sqrt(square / m);
  share_ *= 1.0 + kRate * (std::min(ratio, 3.0) - 1.0);
  share_ = std::clamp(share_, kNarrowest * initial_share_, kWidest * initial_share_);
  learnt_ = true;
  // The simulation now goes where it should have been; by how much is not known before it is there.
  for (double& uncertainty : uncertainty_) uncertainty += variance_;
  for (int i = 0; i < marker_count_ + target_count_; ++i) {
    const auto rows = sensitivity_.middleRows(3 * i, 3);
    multiply(3, r, r, rows.data(), covariance_.data(), gain_.data());
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) learnt_covariance_[i](a, b) = dot(r, gain_.row(a).data(), rows.row(b).data());
  }
}

void StiffnessFilter::apply(AdmmState& state) {
  for (Eigen::Index node = 0; node < field_.rows(); ++node)
    log_stiffness_[node] =
        std::clamp(dot(static_cast<int>(field_.cols()), field_.row(node).data(), coefficients_.data()),
                   -kLargestLogStiffness, kLargestLogStiffness);
  const DomainBlocks& blocks = model_->blocks();
  for (std::size_t slot = 0; slot < blocks.domain.size(); ++slot) {
    if (blocks.domain[slot] < 0) continue;
    const std::vector<int>& anchors = model_->domains()[blocks.domain[slot]].anchors;
    double log_stiffness = 0.0;
    for (int anchor : anchors) log_stiffness += log_stiffness_[anchor];
    state.domains[slot / kLanes].factor[slot % kLanes] = std::exp(log_stiffness / static_cast<double>(anchors.size()));
  }
}

// Gaussian process regression of the markers' discrepancies, its factor the same for all three axes.
void StiffnessFilter::spread_discrepancy() {
  known_.clear();
  for (int i = 0; i < marker_count_; ++i)
    if (uncertainty_[i] < variance_) known_.push_back(i);
  const int m = static_cast<int>(known_.size()), columns = 3 + target_count_;
  for (int i = 0; i < m; ++i) {
    for (int j = 0; j <= i; ++j) kernel_factor_(i, j) = variance_ * kernel_(known_[i], known_[j]);
    kernel_factor_(i, i) += uncertainty_[known_[i]];
    kernel_work_.row(i).head<3>() = discrepancy_[known_[i]].transpose();
    for (int t = 0; t < target_count_; ++t) kernel_work_(i, 3 + t) = variance_ * kernel_(known_[i], marker_count_ + t);
  }
  std::fill(target_shift_.begin(), target_shift_.end(), Vec3::Zero());
  for (int t = 0; t < target_count_; ++t) target_covariance_[t] = variance_ * Mat3::Identity();
  if (m == 0) return;
  Eigen::Ref<Eigen::MatrixXd> in_place(kernel_factor_.topLeftCorner(m, m));
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  forward_substitute(m, columns, kernel_factor_.data(), kernel_factor_.outerStride(), kernel_work_.data());
  for (int t = 0; t < target_count_; ++t) {
    double known = 0.0;
    for (int i = 0; i < m; ++i) {
      target_shift_[t] += kernel_work_(i, 3 + t) * kernel_work_.row(i).head<3>().transpose();
      known += kernel_work_(i, 3 + t) * kernel_work_(i, 3 + t);
    }
    target_covariance_[t].diagonal().array() -= known;
  }
}

// Adds what is not known of the stiffness, in proportion to the load, and the noise that registration leaves.
void StiffnessFilter::update_covariances() {
  const double scale = sensitivity_load_ > 0.0 ? load_ / sensitivity_load_ : 0.0;
  const double unlearnt = learnt_ ? 0.0 : kUnlearntShare * load_;
  for (int t = 0; t < target_count_; ++t) {
    target_covariance_[t] += scale * scale * learnt_covariance_[marker_count_ + t];
    target_covariance_[t].diagonal().array() += noise_variance_ + unlearnt * unlearnt;
  }
}

}  // namespace tissued::core
