#include "core/diagnosis/discretisation.hpp"

#include <array>
#include <optional>

#include "core/refined_mesh.hpp"

namespace tissued::core {

namespace {

constexpr std::array<double, 2> kShares{0.35, 0.7};  // of the push
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
std::optional<RowMatrix> along(const Scene& scene, std::span<const PadInput> pads) {
  PathSolver solver(scene, {});
  FemState state = rest_state(solver.model());
  RowMatrix values(static_cast<Eigen::Index>(kShares.size()), channels_of(scene).count());
  for (std::size_t i = 0; i < kShares.size(); ++i) {
    const std::vector<PadInput> part = part_of(scene, pads, kShares[i]);
    if (!solve_static(solver.equilibrium(), state, {part, nullptr}, kControl).converged) return std::nullopt;
    values.row(static_cast<Eigen::Index>(i)) = solver.observe(state, part);
  }
  return values;
}

}  // namespace

FinerAnswer finer_answer(const Scene& scene, std::span<const PadInput> pads) {
  constexpr double kUnloaded = 1e-3;  // N
  FinerAnswer answer;
  Scene fine = scene;
  fine.mesh = refined(scene.mesh).mesh;
  const std::optional<RowMatrix> own = along(scene, pads), finer = own ? along(fine, pads) : std::nullopt;
  if (!finer) return answer;
  answer.solved = true;
  const Channels channels = channels_of(scene);
  const double span = kShares[1] - kShares[0];
  RowMatrix differs = *finer - *own;
  differs.rightCols(3 * channels.pads).setZero();
  answer.bend = (differs.row(1) / kShares[1] - differs.row(0) / kShares[0]) / span;
  answer.slope = differs.row(0) / kShares[0] - kShares[0] * answer.bend;
  answer.force_ratio = Eigen::RowVectorXd::Ones(channels.pads);
  answer.force_change = Eigen::RowVectorXd::Zero(channels.pads);
  for (int pad = 0; pad < channels.pads; ++pad) {
    std::array<double, 2> ratio{};
    for (Eigen::Index i = 0; i < 2; ++i) {
      const double force = own->row(i).segment<3>(channels.of_force(pad)).norm();
      ratio[i] = force > kUnloaded ? finer->row(i).segment<3>(channels.of_force(pad)).norm() / force : 1.0;
    }
    answer.force_change[pad] = (ratio[1] - ratio[0]) / span;
    answer.force_ratio[pad] = ratio[0] - kShares[0] * answer.force_change[pad];
  }
  return answer;
}

}  // namespace tissued::core
