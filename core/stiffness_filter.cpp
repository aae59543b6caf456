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
constexpr double kScaleSd = 0.5;        // of the logarithm of the stiffness as a whole
constexpr double kForceShare = 0.1;     // of a measured force: what stiffness does not explain of it
constexpr double kForceNoise = 0.02;    // N, of a force sensor
constexpr double kUnlearntShare = 0.1;  // of the load: what may be off before anything was learnt

// With a last column for the stiffness as a whole.
RowMatrix field_with_scale(const Model& model, const FilterOptions& options) {
  const RowMatrix field =
      stiffness_field(model.scene().mesh.rest, options.stiffness_sd, options.stiffness_length, kMostCoefficients);
  RowMatrix all(field.rows(), field.cols() + 1);
  all << field, Eigen::VectorXd::Constant(field.rows(), kScaleSd);
  return all;
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
      field_(field_with_scale(model, options)),
      noise_variance_(
          std::pow(options.measurement_noise > 0 ? options.measurement_noise : model.scene().marker_noise, 2)),
      initial_share_(options.discrepancy),
      slip_share_(options.slip),
      discrepancy_(model, noise_variance_) {
  const auto markers = static_cast<std::size_t>(marker_count_), targets = static_cast<std::size_t>(target_count_);
  const Eigen::Index r = field_.cols(), pads = static_cast<Eigen::Index>(model.scene().pads.size()),
                     m = marker_count_ + pads, observed = compliance_.observed() + 3 * pads;
  displacement_.assign(markers, Vec3::Zero());
  innovation_.assign(markers, Vec3::Zero());
  used_.reserve(markers);
  refused_.reserve(markers);
  moved_.assign(markers, 0.0);
  squares_.reserve(markers);
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
  news_ = Eigen::VectorXd::Zero(3 * m);
  weighed_.reserve(model.scene().pads.size());
  force_innovation_.assign(model.scene().pads.size(), Vec3::Zero());
  force_noise_.assign(model.scene().pads.size(), 0.0);
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
  discrepancy_.reset();
  displacement_before_.assign(markers, Vec3::Zero());
  resting_at_.assign(markers, Vec3::Zero());
  next_domain_ = 0;
  resting_ = load_ = travel_ = peak_load_ = sensitivity_load_ = 0.0;
  held_.assign(model_->scene().pads.size(), 0);
  compliance_.hold(held_);
  std::fill(learnt_covariance_.begin(), learnt_covariance_.end(), Mat3::Zero());
  std::fill(target_covariance_.begin(), target_covariance_.end(), Mat3::Zero());
  update_covariances();
}

Innovation StiffnessFilter::correct(std::span<const Vec3> markers, std::span<const std::uint8_t> seen,
                                    std::span<const PadInput> pads, std::span<const Vec3> pad_forces, double pressed,
                                    double dt, AdmmState& state) {
  see_pads(pads, pad_forces);
  measure(markers, seen, pressed, state);
  variance_ = std::max(expected_variance(), shown_variance());
  gate(markers);
  Innovation result;
  result.markers_used = static_cast<int>(used_.size());
  result.markers_swapped = swapped_;
  double sum = 0.0;
  for (int marker : used_) sum += innovation_[marker].squaredNorm();
  if (!used_.empty()) result.rms = std::sqrt(sum / (3.0 * result.markers_used));
  discrepancy_.follow(innovation_, used_, moved_, share_, load_, dt);
  if (load_is_news(pressed, dt) && !used_.empty()) {
    learn_in_parts(state);
  } else {
    next_domain_ = 0;
  }
  discrepancy_.explain(variance_, slip_variance());
  update_covariances();
  return result;
}

// Which pads hold, and which say how hard they push.
void StiffnessFilter::see_pads(std::span<const PadInput> pads, std::span<const Vec3> pad_forces) {
  bool changed = false;
  forced_ = false;
  weighed_.clear();
  for (std::size_t pad = 0; pad < pads.size(); ++pad) {
    const std::uint8_t holds = pads[pad].kind == PadInput::Kind::pose ? 1 : 0;
    changed = changed || holds != held_[pad];
    held_[pad] = holds;
    forced_ = forced_ || pads[pad].kind == PadInput::Kind::force;
    if (!holds || !pads[pad].measured_force || !pads[pad].measured_force->allFinite()) continue;
    weighed_.push_back(static_cast<int>(pad));
    force_innovation_[pad] = *pads[pad].measured_force - pad_forces[pad];
    force_noise_[pad] = kForceNoise + kForceShare * pads[pad].measured_force->norm();
  }
  if (!changed) return;
  compliance_.hold(held_);
  discrepancy_.hold(compliance_, held_);
}

// Innovations of the markers seen, against the simulation; displacements are compared: where exactly a marker was glued
// cancels.
void StiffnessFilter::measure(std::span<const Vec3> markers, std::span<const std::uint8_t> seen, double pressed,
                              const AdmmState& state) {
  used_.clear();
  load_ = pressed;
  for (int i = 0; i < marker_count_; ++i) {
    const MaterialPoint& point = model_->marker_points()[i];
    displacement_[i] = position_of(point, state.x) - position_of(point, model_->rest());
    load_ = std::max(load_, displacement_[i].norm());
    moved_[i] = (displacement_[i] - displacement_before_[i]).norm();
    displacement_before_[i] = displacement_[i];
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
  for (int marker : used_)
    squares_.push_back((innovation_[marker] - discrepancy_.slip_at_marker(marker)).squaredNorm());
  const auto middle = squares_.begin() + static_cast<std::ptrdiff_t>(squares_.size() / 2);
  std::nth_element(squares_.begin(), middle, squares_.end());
  return std::max(0.0, *middle / kMedian - noise_variance_);
}

bool StiffnessFilter::plausible(int marker, const Vec3& innovation) const {
  const double unlearnt = learnt_ ? 0.0 : kUnlearntShare * load_;
  Mat3 covariance = learnt_covariance_[marker];
  covariance.diagonal().array() += variance_ + unlearnt * unlearnt + noise_variance_;
  const auto slip = discrepancy_.slip_rows().block(3 * marker, 0, 3, discrepancy_.slips());
  covariance += slip_variance() * slip.lazyProduct(slip.transpose());
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

// Whether the load is at rest and says something that it did not say before.
bool StiffnessFilter::load_is_news(double pressed, double dt) {
  travel_ = largest_distance(displacement_, learnt_at_);
  if (pressed > 0.0 || largest_distance(displacement_, resting_at_) > kStill) {
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
  add_rows(static_cast<int>(domain_row_.cols()), static_cast<int>(corner_rows_.size()), corner_rows_.data(),
           corner_factors_.data(), compliance_.columns().data(), domain_row_.data());
  for (int anchor : domain.anchors) at_nodes_.row(anchor) += domain_row_.row(0);
}

// J: a stiffer element holds what its stress pushed, hence the sign; a pad that moves it pushes back.
void StiffnessFilter::finish_sensitivity() {
  sensitivity_.setZero();
  subtract_transposed_product(static_cast<int>(at_nodes_.rows()), static_cast<int>(at_nodes_.cols()),
                              static_cast<int>(field_.cols()), at_nodes_.data(), field_.data(), sensitivity_.data());
  const Eigen::Index places = compliance_.observed();
  sensitivity_.bottomRows(sensitivity_.rows() - places) *= -1.0 / kMillinewtonPerNewton;
  if (!forced_) sensitivity_.col(sensitivity_.cols() - 1).head(places).setZero();  // exactly; the rest is rounding
  sensitivity_load_ = load_;
}

// Of the markers used, then of the pads weighed: J, and what is to be explained. Returns how many rows there are.
int StiffnessFilter::fill_rows() {
  int row = 0;
  const auto add = [&](Eigen::Index first, const Vec3& news) {
    rows_.middleRows(row, 3) = sensitivity_.middleRows(first, 3);
    news_.segment<3>(row) = news;
    row += 3;
  };
  for (int marker : used_) add(3 * marker, discrepancy_.at_marker(marker));
  for (int pad : weighed_) add(compliance_.observed() + 3 * pad, force_innovation_[pad]);
  return row;
}

// The covariance of what is to be explained, lower triangle.
void StiffnessFilter::fill_spread(int rows) {
  const int r = static_cast<int>(field_.cols()), of_markers = 3 * static_cast<int>(used_.size());
  const double share_of_news = std::max(1.0, kFreshTravel / travel_);
  const RowMatrix& slips = discrepancy_.slip_rows();
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j <= i; ++j) spread_(i, j) = dot(r, spread_rows_.row(i).data(), rows_.row(j).data());
  for (int i = 0; i < of_markers; ++i) {
    const int marker = used_[i / 3];
    for (int j = 0; j <= i; ++j) {
      const int other = used_[j / 3];
      spread_(i, j) +=
          share_of_news * slip_variance() *
          dot(discrepancy_.slips(), slips.row(3 * marker + i % 3).data(), slips.row(3 * other + j % 3).data());
      if (i % 3 == j % 3)
        spread_(i, j) += share_of_news * expected_variance() * discrepancy_.correlation(marker, other);
    }
    spread_(i, i) += discrepancy_.uncertainty(marker);
  }
  for (int i = of_markers; i < rows; ++i)
    spread_(i, i) += share_of_news * std::pow(force_noise_[weighed_[(i - of_markers) / 3]], 2);
}

// Kalman update of the coefficients from the markers used and the pads weighed.
void StiffnessFilter::learn() {
  const int r = static_cast<int>(field_.cols()), of_markers = 3 * static_cast<int>(used_.size());
  covariance_ *= 1.0 - kForgetting;
  covariance_.diagonal().array() += kForgetting;
  const int m = fill_rows();
  multiply(m, r, r, rows_.data(), covariance_.data(), spread_rows_.data());
  fill_spread(m);
  Eigen::Ref<Eigen::MatrixXd> in_place(spread_.topLeftCorner(m, m));
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(in_place);
  forward_substitute(m, r, spread_.data(), spread_.outerStride(), spread_rows_.data());
  // gain_'s first column: L^-1 innovation.
  double square = 0.0;
  for (int i = 0; i < m; ++i) {
    double value = news_[i];
    for (int k = 0; k < i; ++k) value -= spread_(i, k) * gain_(k, 0);
    gain_(i, 0) = value / spread_(i, i);
    if (i < of_markers) square += gain_(i, 0) * gain_(i, 0);
  }
  for (int i = 0; i < m; ++i) coefficients_ += gain_(i, 0) * spread_rows_.row(i).transpose();
  subtract_transposed_product(m, r, r, spread_rows_.data(), spread_rows_.data(), covariance_.data());
  // How large the discrepancy is, innovations say: their mean square in units of their covariance ought to be 1.
  constexpr double kRate = 0.1, kNarrowest = 0.5, kWidest = 3.0;
  const double ratio = std::sqrt(square / of_markers);
  share_ *= 1.0 + kRate * (std::min(ratio, 3.0) - 1.0);
  share_ = std::clamp(share_, kNarrowest * initial_share_, kWidest * initial_share_);
  learnt_ = true;
  // The simulation now goes where it should have been; by how much is not known before it is there.
  discrepancy_.widen(variance_);
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

// Adds what is not known of the stiffness, in proportion to the load, and the noise that registration leaves.
void StiffnessFilter::update_covariances() {
  const double scale = sensitivity_load_ > 0.0 ? load_ / sensitivity_load_ : 0.0;
  const double unlearnt = learnt_ ? 0.0 : kUnlearntShare * load_;
  for (int t = 0; t < target_count_; ++t) {
    target_covariance_[t] = discrepancy_.covariance(t) + scale * scale * learnt_covariance_[marker_count_ + t];
    target_covariance_[t].diagonal().array() += noise_variance_ + unlearnt * unlearnt;
  }
}

}  // namespace tissued::core
