#include "tests/core/textbook_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tissued::core::testing {

namespace {

// L of the plain weights kappa + 4/3 mu, dense, on the free nodes.
Eigen::MatrixXd dense_laplacian(const Model& model) {
  const TetMesh& mesh = model.scene().mesh;
  const Material& material = model.scene().material;
  Eigen::MatrixXd l = Eigen::MatrixXd::Zero(mesh.node_count(), mesh.node_count());
  for (const Tet& tet : mesh.tets) {
    Eigen::Matrix4d affine;  // rows: 1, x, y, z of the corners; its inverse holds the shape functions
    for (int a = 0; a < 4; ++a) affine.col(a) << 1.0, mesh.node(tet[a]);
    const Eigen::Matrix<double, 4, 3> gradients = affine.inverse().rightCols<3>();
    const double weight =
        (material.bulk_modulus() + 4.0 / 3.0 * material.shear_modulus()) * std::abs(affine.determinant()) / 6.0;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) l(tet[a], tet[b]) += weight * gradients.row(a).dot(gradients.row(b));
  }
  const std::vector<int>& free = model.system().free_nodes();
  return l(free, free);
}

// Solves P = S P S^T + Q by doubling.
Eigen::MatrixXd stationary(Eigen::MatrixXd s, Eigen::MatrixXd q) {
  for (int i = 0; i < 40; ++i) {
    q += s * q * s.transpose();
    s = s * s;
  }
  return q;
}

}  // namespace

TextbookFilter::TextbookFilter(const Model& model, NoisePreset preset, double process_size, double marker_variance,
                               double pad_variance)
    : model_(model),
      marker_variance_(marker_variance),
      pad_variance_(pad_variance),
      free_(model.system().free_count()) {
  const Eigen::VectorXd masses = model.masses()(model.system().free_nodes());
  const double dt2 = model.time_step() * model.time_step();
  const Eigen::MatrixXd mass = masses.asDiagonal();
  const Eigen::MatrixXd a = (mass + dt2 * dense_laplacian(model)).ldlt().solve(mass);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(free_, free_), zero = Eigen::MatrixXd::Zero(free_, free_);
  transition_.resize(2 * free_, 2 * free_);
  transition_ << 2.0 * a, -a, identity, zero;
  process_ = Eigen::MatrixXd::Zero(2 * free_, 2 * free_);
  covariance = process_;
  if (preset == NoisePreset::paper) {
    process_.diagonal().setConstant(process_size);
    return;
  }
  // Body forces of covariance M through the compliance (M / dt^2 + L)^-1 = dt^2 A M^-1 of one step.
  const Eigen::MatrixXd compliance = dt2 * a * masses.cwiseInverse().asDiagonal();
  process_.topLeftCorner(free_, free_) = compliance * mass * compliance.transpose();
  process_ *= process_size / marker_prior();
}

double TextbookFilter::marker_prior() const {
  const Eigen::MatrixXd p = stationary(transition_, process_);
  double sum = 0.0;
  for (const MaterialPoint& point : model_.marker_points()) {
    const Eigen::RowVectorXd row = row_of(point);
    sum += row * p.topLeftCorner(free_, free_) * row.transpose();
  }
  return sum / static_cast<double>(model_.marker_points().size());
}

Eigen::RowVectorXd TextbookFilter::row_of(const MaterialPoint& point) const {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(free_);
  for (int a = 0; a < point.count; ++a)
    if (const int free = model_.system().free_index()[point.nodes[a]]; free >= 0) row[free] += point.weights[a];
  return row;
}

void TextbookFilter::settle(const std::vector<std::uint8_t>& seen, const std::vector<std::uint8_t>& held_pads,
                            int frames) {
  for (int i = 0; i < frames; ++i) step(seen, held_pads, 1);
}

void TextbookFilter::step(const std::vector<std::uint8_t>& seen, const std::vector<std::uint8_t>& held_pads,
                          int frames) {
  for (int i = 0; i < frames; ++i) covariance = transition_ * covariance * transition_.transpose() + process_;
  std::vector<Eigen::RowVectorXd> rows;
  std::vector<double> variances;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    rows.push_back(row_of(model_.marker_points()[i]));
    variances.push_back(marker_variance_);
  }
  for (std::size_t p = 0; p < held_pads.size(); ++p) {
    if (!held_pads[p]) continue;
    for (int node : model_.pad_nodes()[p]) {
      if (model_.system().free_index()[node] < 0) continue;
      rows.push_back(Eigen::RowVectorXd::Unit(free_, model_.system().free_index()[node]));
      variances.push_back(pad_variance_);
    }
  }
  const auto count = static_cast<Eigen::Index>(rows.size());
  gain_ = Eigen::MatrixXd::Zero(2 * free_, count);
  if (count == 0) return;
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(count, 2 * free_), r = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    h.row(i).head(free_) = rows[static_cast<std::size_t>(i)];
    r(i, i) = variances[static_cast<std::size_t>(i)];
  }
  const Eigen::MatrixXd innovation = h * covariance * h.transpose() + r;
  gain_ = innovation.ldlt().solve(h * covariance).transpose();
  const Eigen::MatrixXd keep = Eigen::MatrixXd::Identity(2 * free_, 2 * free_) - gain_ * h;
  covariance = keep * covariance * keep.transpose() + gain_ * r * gain_.transpose();  // Joseph's form
}

double TextbookFilter::target_variance(int target) const {
  const Eigen::RowVectorXd row = row_of(model_.target_points()[target]);
  return row * covariance.topLeftCorner(free_, free_) * row.transpose();
}

}  // namespace tissued::core::testing
