// The static answer of admm against FEniCSx's linear tetrahedra (../shared/reference/README.md): the same
// discretisation has the same minimiser.
#include <catch2/catch.hpp>

#include "core/static_solve.hpp"
#include "tests/daemon/reference_cases.hpp"

using namespace tissued;
using namespace tissued::daemon::testing;

TEST_CASE("admm meets the reference answers of linear tetrahedra at every node") {
  const nlohmann::json index = reference_index();
  if (index.is_null()) return;
  REQUIRE(index.size() == 5);
  // Whatever the weights start from: where the lightest cycle, the solve must find out of it.
  const double weights = GENERATE(1.0, 4.0);
  for (const auto& [name, asked] : index.items()) {
    INFO(name << ", weights x " << weights);
    const core::Scene scene = reference_scene(asked);
    core::StaticOptions options;
    options.element = core::Element::p1;
    options.weight_scale = weights;
    const core::StaticSolution solution = core::solve_static(scene, reference_pads(scene, asked), options);
    REQUIRE(solution.converged);
    const Eigen::MatrixX3d moved = solution.positions.leftCols<3>() - scene.mesh.rest;
    CHECK(furthest_from_reference(scene, moved, name) < 1e-3);
    CHECK(worst_force(scene, solution.pad_forces, asked.at("P1")) < 1e-4);
  }
}

TEST_CASE("what cannot converge says so") {
  const nlohmann::json index = reference_index();
  if (index.is_null()) return;
  const auto& asked = index.at("dome-a1-10");
  const core::Scene scene = reference_scene(asked);
  core::StaticOptions options;
  options.max_iterations = 3;
  const core::StaticSolution solution = core::solve_static(scene, reference_pads(scene, asked), options);
  CHECK_FALSE(solution.converged);
  CHECK(solution.trouble.find("not converged after 3 iterations") != std::string::npos);
}
