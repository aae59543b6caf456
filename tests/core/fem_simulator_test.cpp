// `fem` behind the simulators' interface: frame by frame it is where whole solves are.
#include <catch2/catch.hpp>

#include "core/fem_solver.hpp"
#include "core/simulator.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

SimulatorOptions options_of(FemElement element) {
  SimulatorOptions options;
  options.kind = "fem";
  options.fem.element = element;
  options.solver.threads = 1;
  return options;
}

Observation pushed(const Scene& scene, double depth) {
  Observation observation;
  observation.resize_for(scene);
  observation.pads[0].kind = PadInput::Kind::pose;
  observation.pads[0].center = scene.pads[0].center + depth * scene.pads[0].direction;
  return observation;
}

}  // namespace

TEST_CASE("fem, quasi-static, is where a whole solve is, and is reset to rest", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const auto simulator = make_simulator(scene, options_of(element));
  const std::uint64_t at_rest = simulator->state_hash();
  for (int n = 1; n <= 6; ++n) REQUIRE(simulator->step(pushed(scene, 0.5 * n)).converged);
  FemOptions options;
  options.element = element;
  const FemModel model(scene, options);
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  const std::vector<PadInput> pads = pushed(scene, 3.0).pads;
  REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
  for (int i = 0; i < scene.mesh.node_count(); ++i)
    CHECK((simulator->positions().row(i).head<3>().transpose() - state.x.segment<3>(3 * i)).norm() < 1e-5);
  const Eigen::VectorXd moved = state.x - model.rest();
  CHECK((simulator->target(1).position - scene.targets[1].rest - position_of(model.target_points()[1], moved)).norm() <
        1e-5);
  CHECK((simulator->marker(2) - scene.markers[2].rest - position_of(model.marker_points()[2], moved)).norm() < 1e-5);
  CHECK((simulator->pad_force(0) - pad_forces(state, pads)[0]).norm() < 1e-5);
  simulator->reset();
  CHECK(simulator->state_hash() == at_rest);
  CHECK(simulator->pad_force(0).norm() == 0.0);
}

TEST_CASE("fem says how far a pad is that it cannot follow, and follows it again", "[fem]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const auto simulator = make_simulator(scene, options_of(FemElement::p2));
  const StepReport stuck = simulator->step(pushed(scene, 30.0));
  CHECK_FALSE(stuck.converged);
  CHECK(stuck.pad_ramp > 10.0);
  CHECK(simulator->positions().allFinite());
  const StepReport again = simulator->step(pushed(scene, 2.0));
  CHECK(again.converged);
  CHECK(again.pad_ramp == 0.0);
}

TEST_CASE("fem with inertia lags behind its pad and comes to rest where it is without", "[fem]") {
  const Scene scene = box_scene({2, 2, 2, 10.0});
  SimulatorOptions options = options_of(FemElement::p1);
  const auto still = make_simulator(scene, options);
  REQUIRE(still->step(pushed(scene, 2.0)).converged);
  options.fem.dynamics = TimeScheme{TimeScheme::Kind::generalized_alpha, 0.5};
  options.fem.damping.mass = 60.0;
  const auto moving = make_simulator(scene, options);
  REQUIRE(moving->step(pushed(scene, 2.0)).converged);
  const double early = (moving->target(0).position - still->target(0).position).norm();
  for (int n = 0; n < 200; ++n) REQUIRE(moving->step(pushed(scene, 2.0)).converged);
  const double late = (moving->target(0).position - still->target(0).position).norm();
  CHECK(early > 0.05);
  CHECK(late < 1e-3);
}
