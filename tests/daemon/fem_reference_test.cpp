// fem against FEniCSx (../shared/reference/README.md), linear tetrahedra at every node and quadratic ones at markers,
// targets and pads.
#include <catch2/catch.hpp>

#include "core/fem_solver.hpp"
#include "tests/daemon/reference_cases.hpp"

using namespace tissued;
using namespace tissued::daemon::testing;

namespace {

struct Answer {
  Eigen::MatrixX3d moved;              // (corner nodes x 3) mm
  std::vector<core::Vec3> points;      // mm, displacement of markers, then targets
  std::vector<core::Vec3> pad_forces;  // N
};

Answer solve(const core::Scene& scene, const std::vector<core::PadInput>& pads, core::FemElement element) {
  core::FemOptions options;
  options.element = element;
  const core::FemModel model(scene, options);
  core::FemEquilibrium equilibrium(model, 2);
  core::FemState state = core::rest_state(model);
  const core::FemReport report = core::solve_static(equilibrium, state, {pads}, core::FemControl{});
  INFO(report.words());
  REQUIRE(report.converged);
  Answer answer;
  const Eigen::VectorXd moved = state.x - model.rest();
  answer.moved.resize(scene.mesh.node_count(), 3);
  for (int i = 0; i < scene.mesh.node_count(); ++i) answer.moved.row(i) = moved.segment<3>(3 * i).transpose();
  const auto read = [&](const core::Vec3& rest) {
    const core::FemPoint point = core::fem_point(model.mesh(), core::locate_in_volume(scene.mesh, rest));
    answer.points.push_back(core::position_of(point, moved));
  };
  for (const auto& marker : scene.markers) read(marker.rest);
  for (const auto& target : scene.targets) read(target.rest);
  answer.pad_forces = core::pad_forces(state, pads);
  return answer;
}

double worst_point(const core::Scene& scene, const Answer& answer, const nlohmann::json& expected) {
  std::vector<std::string> names;
  for (const auto& marker : scene.markers) names.push_back(marker.name);
  for (const auto& target : scene.targets) names.push_back(target.name);
  REQUIRE(names.size() == expected.at("displacement_mm").size());
  double worst = 0.0;
  for (std::size_t k = 0; k < names.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      worst = std::max(worst, std::abs(answer.points[k][static_cast<int>(axis)] -
                                       expected.at("displacement_mm").at(names[k])[axis].get<double>()));
  return worst;
}

}  // namespace

TEST_CASE("fem with linear tetrahedra meets the reference answers at every node") {
  const nlohmann::json index = reference_index();
  for (const auto& [name, asked] : index.items()) {
    INFO(name);
    const core::Scene scene = reference_scene(asked);
    const Answer answer = solve(scene, reference_pads(scene, asked), core::FemElement::p1);
    CHECK(furthest_from_reference(scene, answer.moved, name) < 1e-6);
    CHECK(worst_point(scene, answer, asked.at("P1")) < 1e-4);
    CHECK(worst_force(scene, answer.pad_forces, asked.at("P1")) < 1e-5);
  }
}

TEST_CASE("fem with quadratic tetrahedra meets the reference answers at markers, targets and pads") {
  const nlohmann::json index = reference_index();
  for (const auto& [name, asked] : index.items()) {
    INFO(name);
    const core::Scene scene = reference_scene(asked);
    const Answer answer = solve(scene, reference_pads(scene, asked), core::FemElement::p2);
    CHECK(worst_point(scene, answer, asked.at("P2")) < 1e-4);
    CHECK(worst_force(scene, answer.pad_forces, asked.at("P2")) < 1e-4);
  }
}
