#include "core/diagnosis/disturbance.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/diagnosis/path_solver.hpp"

namespace tissued::core {

namespace {

constexpr Eigen::Index kPatterns = 2;  // of a trial's misfit that are asked for, the strongest first
constexpr int kSources = 4;            // at a place: a force along each axis, and a pressure

// What a trial's misfit looks like on the skin, in units of noise: the strongest of its course in time, each of the
// length that its part of the misfit has. (3 markers x patterns); rows of markers that are seldom seen are zero.
Eigen::MatrixXd patterns_of(const ErrorModel& errors, const TrialResidual& trial, const Eigen::VectorXd& offset,
                            int channels) {
  RowMatrix misfit = trial.residual.leftCols(channels);
  for (Eigen::Index c = 0; c < channels; ++c) {
    const bool is_seen = 2 * misfit.col(c).array().isFinite().count() > misfit.rows();
    for (Eigen::Index f = 0; f < misfit.rows(); ++f)
      misfit(f, c) = is_seen && std::isfinite(misfit(f, c)) ? (misfit(f, c) - offset[c]) / errors.noise[c] : 0.0;
  }
  const Eigen::MatrixXd square = misfit.transpose() * misfit;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(square);
  const Eigen::VectorXd strength = eigen.eigenvalues().tail(kPatterns).cwiseMax(0.0).cwiseSqrt();
  return eigen.eigenvectors().rightCols(kPatterns) * strength.asDiagonal();
}

// (3n x 3 markers) mm/mN: how the skin's markers answer to a force on any node, about where the body is under the
// trial's largest load.
Eigen::MatrixXd compliance(PathSolver& solver, const LoadPath& path) {
  PathAnswer answer;
  if (!solver.solve(path, 0, {}, answer)) return {};
  std::size_t peak = 0;
  for (std::size_t k = 0; k < path.keys().size(); ++k)
    if (path.keys()[k].load > path.keys()[peak].load) peak = k;
  const FemModel& model = solver.model();
  FemEquilibrium& equilibrium = solver.equilibrium();
  const FemHistory at_rest = rest_state(model).history;
  const Eigen::VectorXd& x = solver.positions(0)[peak];
  if (!equilibrium.factor_at(FemBalance{}, x, at_rest, hold_of(model, path.keys()[peak].pads))) return {};
  const std::vector<FemPoint>& points = model.marker_points();
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(x.size(), 3 * static_cast<Eigen::Index>(points.size()));
  for (std::size_t m = 0; m < points.size(); ++m)
    for (int a = 0; a < points[m].count; ++a)
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        right(3 * points[m].nodes[a] + axis, 3 * static_cast<Eigen::Index>(m) + axis) += points[m].weights[a];
  // The tangent is symmetric: one solve for each marker serves every place of the body.
  return equilibrium.factor().solve(right);
}

// (nodes of the mesh) (3n x 1): forces of a unit of pressure in the tetrahedra around a node, and the node's own.
std::vector<std::vector<std::pair<int, Vec3>>> pressures(const TetMesh& mesh) {
  std::vector<std::vector<std::pair<int, Vec3>>> out(static_cast<std::size_t>(mesh.node_count()));
  for (const Tet& tet : mesh.tets) {
    for (int a = 0; a < 4; ++a) {
      // Of six times the volume by the node: the cross product of the opposite facet's edges, away from it.
      const Vec3 b = mesh.node(tet[(a + 1) % 4]), c = mesh.node(tet[(a + 2) % 4]), d = mesh.node(tet[(a + 3) % 4]);
      Vec3 slope = (c - b).cross(d - b) / 6.0;
      if (slope.dot(mesh.node(tet[a]) - b) < 0.0) slope = -slope;
      for (int center : tet) out[static_cast<std::size_t>(center)].emplace_back(tet[a], slope);
    }
  }
  return out;
}

// How much of the patterns sources at a node explain: the squared length of their projection.
double explained(const Eigen::MatrixXd& answers, const Eigen::MatrixXd& patterns) {
  Eigen::MatrixXd scaled = answers;
  for (Eigen::Index j = 0; j < scaled.cols(); ++j)
    if (const double norm = scaled.col(j).norm(); norm > 0.0) scaled.col(j) /= norm;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::MatrixXd along = qr.householderQ().transpose() * patterns;
  return along.topRows(std::min<Eigen::Index>(qr.rank(), kSources)).squaredNorm();
}

MismatchMap mapped(const TetMesh& mesh, const std::vector<double>& gain) {
  constexpr double kAlmost = 0.97;  // of the largest gain: as good a place
  MismatchMap map;
  const auto best = std::max_element(gain.begin(), gain.end());
  if (best == gain.end() || !(*best > 0.0)) return map;
  const double worst = *std::min_element(gain.begin(), gain.end()), range = std::max(*best - worst, 1e-12);
  for (const Tet& tet : mesh.tets) {
    double mean = 0.0;
    for (int node : tet) mean += 0.25 * (gain[static_cast<std::size_t>(node)] - worst) / range;
    map.of_tet.push_back(mean);
  }
  // The middle of the places that are about as good, and how far they reach.
  double weights = 0.0, square = 0.0;
  for (std::size_t i = 0; i < gain.size(); ++i) {
    const double weight = std::max(0.0, gain[i] / *best - kAlmost);
    map.peak += weight * mesh.node(static_cast<int>(i));
    weights += weight;
  }
  map.peak /= weights;
  for (std::size_t i = 0; i < gain.size(); ++i)
    square += std::max(0.0, gain[i] / *best - kAlmost) * (mesh.node(static_cast<int>(i)) - map.peak).squaredNorm();
  const double edge = std::cbrt(6.0 * std::abs(signed_volume(mesh, mesh.tets.front())));
  map.radius = std::max(edge, std::sqrt(square / weights));
  return map;
}

}  // namespace

MismatchMap disturbance_map(const FitData& data, const Fit& fit) {
  const Scene& scene = data.session->scene;
  const Channels channels = channels_of(scene);
  if (data.session->is_dynamic()) return {};
  PathSolver solver(scene, {});
  set_numbers(fit.hypothesis, fit.unknowns, solver);
  const Nuisances known = nuisances(data.errors, pointers_to(fit.residuals));
  const auto pressure = pressures(scene.mesh);
  std::vector<double> gain(static_cast<std::size_t>(scene.mesh.node_count()), 0.0);
  for (std::size_t k = 0; k < data.paths.size(); ++k) {
    const Eigen::MatrixXd patterns = patterns_of(data.errors, fit.residuals[k], known.offset, 3 * channels.markers);
    const Eigen::MatrixXd by_force = compliance(solver, data.paths[k]);
    if (by_force.size() == 0) continue;
    const Eigen::VectorXd is_seen = (patterns.rowwise().squaredNorm().array() > 0.0).cast<double>();
    for (int node = 0; node < scene.mesh.node_count(); ++node) {
      Eigen::MatrixXd answers = Eigen::MatrixXd::Zero(3 * channels.markers, kSources);
      answers.leftCols(3) = by_force.middleRows(3 * node, 3).transpose();
      for (const auto& [at, force] : pressure[static_cast<std::size_t>(node)])
        answers.col(3) += by_force.middleRows(3 * at, 3).transpose() * force;
      for (int c = 0; c < 3 * channels.markers; ++c) answers.row(c) *= is_seen[c] / data.errors.noise[c];
      gain[static_cast<std::size_t>(node)] += explained(answers, patterns);
    }
  }
  return mapped(scene.mesh, gain);
}

}  // namespace tissued::core
