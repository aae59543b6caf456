#include "core/diagnosis/discretisation.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "core/edge_load.hpp"
#include "core/refined_mesh.hpp"

namespace tissued::core {

namespace {

constexpr std::array<double, 3> kShares{0.35, 0.7, 1.0};  // of the push
// Long steps are the cheapest as long as they succeed; short ones go further before a body folds, where every try is
// dear: one that is shorter still is tried.
constexpr std::array<FemControl, 2> kAlong{FemControl{5e-3, 10, 2.5, 0.9}, FemControl{5e-3, 10, 1.25, 0.3}};
constexpr FemControl kAtRest{5e-3, 20, 2.5, 0.05};

std::vector<PadInput> part_of(const Scene& scene, std::span<const PadInput> pads, double share) {
  std::vector<PadInput> part;
  for (std::size_t i = 0; i < pads.size(); ++i) {
    PadInput rest = pads[i];
    rest.center = scene.pads[i].center;
    rest.rotation.setIdentity();
    rest.force.setZero();
    part.push_back(between(rest, pads[i], share));
  }
  return part;
}

// What channels show where a part of the push was solved for.
struct Course {
  std::vector<double> shares;
  RowMatrix values;  // (shares x channels)
};

// As far as there is an equilibrium.
Course along(const Scene& scene, const Fit& at, std::span<const PadInput> pads, std::span<const double> shares,
             const std::atomic<bool>& stop) {
  constexpr double kApart = 0.3;  // of what a further share asks for: with less it adds nothing
  PathSolver solver(scene, at.hypothesis.effects);
  set_numbers(at.hypothesis, at.unknowns, solver);
  FemState state = rest_state(solver.model());
  Course course{{}, RowMatrix(static_cast<Eigen::Index>(shares.size()), channels_of(scene).count())};
  double reached = 0.0;
  for (const double share : shares) {
    const double before = reached;
    for (FemControl control : kAlong) {
      control.stop = &stop;
      const FemReport report =
          solve_static(solver.equilibrium(), state, {part_of(scene, pads, share), nullptr}, control);
      reached = report.converged ? share : reached + report.load * (share - reached);
      if (report.converged) break;
    }
    if (reached - before < kApart * (share - before)) break;
    const std::vector<PadInput> part = part_of(scene, pads, reached);
    course.values.row(static_cast<Eigen::Index>(course.shares.size())) = solver.observe(state, part);
    course.shares.push_back(reached);
    if (reached < share) break;
  }
  course.values.conservativeResize(static_cast<Eigen::Index>(course.shares.size()), Eigen::NoChange);
  return course;
}

// (channels), of a body that nothing but its weight and loads act on.
std::optional<Eigen::RowVectorXd> at_rest(const Scene& scene, std::span<const EdgeLoad> loads) {
  PathSolver solver(scene, {});
  FemState state = rest_state(solver.model());
  const std::vector<PadInput> none(scene.pads.size());
  const Eigen::VectorXd external = forces_of(solver.model(), loads);
  if (!solve_static(solver.equilibrium(), state, {none, &external}, kAtRest).converged) return std::nullopt;
  return solver.observe(state, none);
}

}  // namespace

std::optional<double> finer_rest(const Scene& scene, std::span<const EdgeLoad> loads) {
  if (scene.mesh.tet_count() > kMostRefinedTets || scene.markers.empty()) return std::nullopt;
  Scene fine = scene;
  fine.mesh = refined(scene.mesh);
  const auto own = at_rest(scene, loads), finer = own ? at_rest(fine, loads) : std::nullopt;
  if (!finer) return std::nullopt;
  const auto seen = static_cast<Eigen::Index>(3 * scene.markers.size());
  return std::sqrt((*finer - *own).head(seen).squaredNorm() / static_cast<double>(seen));
}

FinerAnswer finer_answer(const Scene& scene, const Fit& at, std::span<const PadInput> pads,
                         const std::atomic<bool>& hurry, const std::atomic<bool>& stop) {
  constexpr double kUnloaded = 1e-3;  // N
  FinerAnswer answer;
  Scene fine = scene;
  fine.mesh = refined(scene.mesh);
  const Course finer = along(fine, at, pads, kShares, hurry), own = along(scene, at, pads, finer.shares, stop);
  if (finer.shares.empty() || own.shares != finer.shares) return answer;
  answer.reached = finer.shares.back();
  const auto terms = static_cast<Eigen::Index>(finer.shares.size());
  const Channels channels = channels_of(scene);
  Eigen::MatrixXd powers(terms, terms);
  RowMatrix differs = finer.values - own.values, ratios = RowMatrix::Ones(terms, channels.pads);
  differs.rightCols(3 * channels.pads).setZero();
  for (Eigen::Index i = 0; i < terms; ++i) {
    const double share = finer.shares[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < terms; ++k) powers(i, k) = std::pow(share, k);
    differs.row(i) /= share;
    for (int pad = 0; pad < channels.pads; ++pad) {
      const auto force = [&](const Course& of) { return of.values.row(i).segment<3>(channels.of_force(pad)).norm(); };
      if (force(own) > kUnloaded) ratios(i, pad) = force(finer) / force(own);
    }
  }
  const Eigen::MatrixXd interpolation = powers.inverse();
  answer.differs = interpolation * differs;
  answer.force_ratio = interpolation * ratios;
  return answer;
}

}  // namespace tissued::core
