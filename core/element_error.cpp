#include "core/element_error.hpp"

#include "core/fem_solver.hpp"
#include "core/refined_mesh.hpp"

namespace tissued::core {

namespace {

Scene judged_scene(const Model& model) {
  Scene scene = model.scene();
  if (scene.mesh.tet_count() <= ElementError::kMostRefinedTets) scene.mesh = refined(scene.mesh);
  return scene;
}

// By quadratic elements: (3 x 3 markers), what moving this pad along an axis does. Empty where it cannot be told.
RowMatrix answers_to(const FemModel& model, FemEquilibrium& equilibrium, std::size_t pad) {
  constexpr double kStep = 1e-3;  // mm: forces of a pad that moved so little are its tangent's
  const FemState rest = rest_state(model);
  std::vector<PadInput> pads(model.scene().pads.size());
  pads[pad].kind = PadInput::Kind::pose;
  pads[pad].center = model.scene().pads[pad].center;
  const FemHold at_rest = hold_of(model, pads);
  Eigen::VectorXd residual, moved_residual;
  if (!equilibrium.factor_at(FemBalance{}, rest.x, rest.history, at_rest)) return {};
  equilibrium.terms(rest.x, 0.0, rest.history, residual);
  RowMatrix answers(3, static_cast<Eigen::Index>(3 * model.marker_points().size()));
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd x = rest.x;
    for (std::size_t node = 0; node < at_rest.pad.size(); ++node)
      if (at_rest.pad[node] == static_cast<int>(pad)) x[static_cast<Eigen::Index>(3 * node) + axis] += kStep;
    equilibrium.terms(x, 0.0, rest.history, moved_residual);
    x -= equilibrium.factor().solve(moved_residual - residual);
    for (std::size_t i = 0; i < model.marker_points().size(); ++i)
      answers.row(axis).segment<3>(static_cast<Eigen::Index>(3 * i)) =
          (position_of(model.marker_points()[i], x) - position_of(model.marker_points()[i], rest.x)).transpose() /
          kStep;
  }
  return answers;
}

}  // namespace

ElementError::ElementError(const Model& model, RestCompliance& compliance) {
  const auto markers = static_cast<Eigen::Index>(3 * model.marker_points().size());
  for (const Pad& pad : model.scene().pads) pad_centers_.push_back(pad.center);
  by_pad_ = RowMatrix::Zero(static_cast<Eigen::Index>(3 * pad_centers_.size()), markers);
  std::vector<std::uint8_t> held(pad_centers_.size(), 0);
  if (model.scene().mesh.tet_count() <= kMostTets && markers > 0) try {
      const FemModel judge(judged_scene(model), {});
      FemEquilibrium equilibrium(judge, 1);
      known_ = true;
      for (std::size_t pad = 0; pad < pad_centers_.size(); ++pad) {
        const RowMatrix answers = answers_to(judge, equilibrium, pad);
        if (answers.size() == 0) {
          known_ = false;
          break;
        }
        held[pad] = 1;
        compliance.hold(held);
        held[pad] = 0;
        const auto row = static_cast<Eigen::Index>(3 * pad);
        by_pad_.middleRows(row, 3) = answers - compliance.pad_shift().middleRows(row, 3).leftCols(markers);
      }
    } catch (const ModelError&) {
      known_ = false;  // a mesh that quadratic elements do not take
    }
  compliance.hold(held);
  if (!known_) by_pad_.setZero();
}

Vec3 ElementError::at(int marker, std::span<const PadInput> pads) const {
  Vec3 sum = Vec3::Zero();
  for (std::size_t pad = 0; pad < pads.size(); ++pad) {
    if (pads[pad].kind != PadInput::Kind::pose) continue;
    const Vec3 push = pads[pad].center - pad_centers_[pad];
    for (int axis = 0; axis < 3; ++axis)
      sum += push[axis] * by_pad_.row(static_cast<Eigen::Index>(3 * pad) + axis).segment<3>(3 * marker).transpose();
  }
  return sum;
}

}  // namespace tissued::core
