#include "core/diagnosis/discretisation.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "core/edge_load.hpp"
#include "core/refined_mesh.hpp"

namespace tissued::core {

namespace {

constexpr std::array<double, 3> kShares{0.35, 0.7, 1.0};  // of the push
// Short steps take one factorisation each, long ones many more.
constexpr FemControl kControl{5e-3, 20, 2.5, 0.05};

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

// (shares x channels); nothing where there is no equilibrium.
std::optional<RowMatrix> along(const Scene& scene, const Fit& at, std::span<const PadInput> pads,
                               const std::atomic<bool>* stop) {
  FemControl control = kControl;
  control.stop = stop;
  PathSolver solver(scene, at.hypothesis.effects);
  set_numbers(at.hypothesis, at.unknowns, solver);
  FemState state = rest_state(solver.model());
  RowMatrix values(static_cast<Eigen::Index>(kShares.size()), channels_of(scene).count());
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    const std::vector<PadInput> part = part_of(scene, pads, kShares[i]);
    if (!solve_static(solver.equilibrium(), state, {part, nullptr}, control).converged) return std::nullopt;
    values.row(static_cast<Eigen::Index>(i)) = solver.observe(state, part);
  }
  return values;
}

// (channels), of a body that nothing but its weight and loads act on.
std::optional<Eigen::RowVectorXd> at_rest(const Scene& scene, std::span<const EdgeLoad> loads) {
  PathSolver solver(scene, {});
  FemState state = rest_state(solver.model());
  const std::vector<PadInput> none(scene.pads.size());
  const Eigen::VectorXd external = forces_of(solver.model(), loads);
  if (!solve_static(solver.equilibrium(), state, {none, &external}, kControl).converged) return std::nullopt;
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
                         const std::atomic<bool>* stop) {
  constexpr double kUnloaded = 1e-3;  // N
  FinerAnswer answer;
  Scene fine = scene;
  fine.mesh = refined(scene.mesh);
  const auto own = along(scene, at, pads, stop), finer = own ? along(fine, at, pads, stop) : std::nullopt;
  if (!finer) return answer;
  answer.solved = true;
  const Channels channels = channels_of(scene);
  Mat3 powers;
  for (Eigen::Index i = 0; i < 3; ++i) powers.row(i) << 1.0, kShares[i], kShares[i] * kShares[i];
  const Mat3 interpolation = powers.inverse();
  RowMatrix differs = *finer - *own, ratios = RowMatrix::Ones(3, channels.pads);
  differs.rightCols(3 * channels.pads).setZero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    differs.row(i) /= kShares[i];
    for (int pad = 0; pad < channels.pads; ++pad) {
      const double force = own->row(i).segment<3>(channels.of_force(pad)).norm();
      if (force > kUnloaded) ratios(i, pad) = finer->row(i).segment<3>(channels.of_force(pad)).norm() / force;
    }
  }
  answer.differs = interpolation * differs;
  answer.force_ratio = interpolation * ratios;
  return answer;
}

}  // namespace tissued::core
