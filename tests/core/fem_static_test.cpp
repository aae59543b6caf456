// Equilibria of fem against answers in closed form and against Newton's method on a plain sum of energies.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/fem_solver.hpp"
#include "tests/core/newton_twin.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

FemOptions of_element(FemElement element) {
  FemOptions options;
  options.element = element;
  return options;
}

PadInput posed(const Pad& pad, const Vec3& way, double turn = 0.0) {
  PadInput input;
  input.kind = PadInput::Kind::pose;
  input.center = pad.center + way;
  input.rotation = Eigen::AngleAxisd(turn, Vec3(1.0, 0.5, 0.2).normalized()).toRotationMatrix();
  return input;
}

struct Solved {
  FemReport report;
  FemState state;
  std::vector<Vec3> forces;
};

Solved solve(const FemModel& model, const std::vector<PadInput>& pads, int threads = 1) {
  FemEquilibrium equilibrium(model, threads);
  Solved out{{}, rest_state(model), {}};
  out.report = solve_static(equilibrium, out.state, {pads}, FemControl{});
  out.forces = pad_forces(out.state, pads);
  return out;
}

}  // namespace

TEST_CASE("a patch under affine motion of its boundary moves affinely inside", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({3, 3, 3, 10.0});
  const FemModel model(scene, of_element(element));
  Mat3 f;
  f << 1.2, 0.1, -0.05, 0.0, 0.9, 0.15, 0.1, -0.1, 1.1;
  FemHold hold = hold_of(model, std::vector<PadInput>(2));
  Eigen::VectorXd expected(3 * model.mesh().node_count());
  for (int i = 0; i < model.mesh().node_count(); ++i)
    expected.segment<3>(3 * i) = f * model.mesh().rest.row(i).transpose();
  for (int node : nodes_of(model.mesh(), {"all", boundary_of(scene.mesh)})) hold.held[node] = 1;
  hold.position = expected;
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  FemBalance balance;
  balance.offset.setZero(state.x.size());
  const FemReport report = equilibrium.find(balance, hold, state.history, FemControl{}, state.x);
  REQUIRE(report.converged);
  CHECK((state.x - expected).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("linear tetrahedra are where the twin finds them", "[fem]") {
  Scene scene = box_scene({3, 2, 2, 10.0});
  scene.gravity = Vec3(0.2, 0.0, -0.6);
  const FemModel model(scene, of_element(FemElement::p1));
  PadInput force;
  force.kind = PadInput::Kind::force;
  force.force = Vec3(0.02, 0.01, -0.1);
  const std::vector<PadInput> pads{posed(scene.pads[0], Vec3(0.5, 0.3, -4.0), 0.2), force};
  const TwinAnswer twin = solve_by_newton(scene, pads, external_forces(scene, pads), 4);
  REQUIRE(twin.unbalanced < 1e-8);
  const Solved solved = solve(model, pads);
  REQUIRE(solved.report.converged);
  double furthest = 0.0;
  for (int i = 0; i < scene.mesh.node_count(); ++i)
    furthest =
        std::max(furthest, (solved.state.x.segment<3>(3 * i) - twin.positions.row(i).head<3>().transpose()).norm());
  CHECK(furthest < 1e-7);
  Vec3 held = Vec3::Zero();
  for (int node : nodes_of(*scene.mesh.find_surface("A1"))) held += twin.reactions[node];
  // A node of both pads carries a share of the second's force, too.
  CHECK((solved.forces[0] - held).norm() < 1e-6);
  CHECK(solved.forces[1] == force.force);
}

TEST_CASE("a cantilever of quadratic tetrahedra bends as Timoshenko's", "[fem]") {
  constexpr double kEdge = 5.0, kLength = 100.0, kWidth = 10.0, kForce = 1e-5;  // mm, N
  Scene scene = box_scene({2, 2, 20, kEdge});
  scene.material = {6.0, 0.0, 1.0};  // nu = 0: the clamp hinders no lateral strain, as in the beam theory
  scene.targets = {{"tip", Vec3(0.5 * kWidth, 0.5 * kWidth, kLength - 1e-6)}};
  scene.markers.clear();
  const FemModel model(scene, of_element(FemElement::p2));
  SurfaceGroup top{"top", {}};
  for (const Triangle& t : boundary_of(scene.mesh))
    if (std::min({scene.mesh.node(t[0]).z(), scene.mesh.node(t[1]).z(), scene.mesh.node(t[2]).z()}) > kLength - 1e-9)
      top.triangles.push_back(t);
  Eigen::VectorXd external = Eigen::VectorXd::Zero(3 * model.mesh().node_count());
  const std::vector<int> nodes = nodes_of(model.mesh(), top);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    external[3 * nodes[k]] = 1e3 * kForce * shares_of(model.mesh(), top)[k];
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  const std::vector<PadInput> pads(2);
  REQUIRE(solve_static(equilibrium, state, {pads, &external}, FemControl{}).converged);
  const double e = 6.0e-3, g = 3.0e-3;  // N/mm2
  const double area = kWidth * kWidth, inertia = std::pow(kWidth, 4) / 12.0;
  const double expected =
      kForce * std::pow(kLength, 3) / (3.0 * e * inertia) + kForce * kLength / (5.0 / 6.0 * g * area);
  const double tip = position_of(model.target_points()[0], state.x).x() - 0.5 * kWidth;
  CHECK(tip == Approx(expected).epsilon(3e-3));
}

TEST_CASE("loads may change in any way from one solve to the next", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  Scene scene = box_scene({3, 2, 2, 10.0});
  FemModel model(scene, of_element(element));
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  std::vector<PadInput> pads{posed(scene.pads[0], Vec3(0.0, 1.0, -3.0)), PadInput{}};
  REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
  // The first pad leaves, the second touches, the stiffness and the weight change.
  pads = {PadInput{}, posed(scene.pads[1], Vec3(1.0, 0.0, -2.0), 0.1)};
  model.set_parameter("youngs_modulus", 9.0);
  model.set_parameter("gravity_z", -0.5);
  REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
  scene.material.youngs_modulus = 9.0;
  scene.gravity.z() = -0.5;
  const FemModel fresh(scene, of_element(element));
  const Solved direct = solve(fresh, pads);
  REQUIRE(direct.report.converged);
  CHECK((state.x - direct.state.x).cwiseAbs().maxCoeff() < 1e-7);
  CHECK((pad_forces(state, pads)[1] - direct.forces[1]).norm() < 1e-8);
}

TEST_CASE("one thread and two give the same bits", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  // So large that the second thread is used.
  const Scene scene = element == FemElement::p1 ? box_scene({10, 10, 10, 4.0}) : box_scene({6, 6, 5, 8.0});
  const FemModel model(scene, of_element(element));
  const std::vector<PadInput> pads{posed(scene.pads[0], Vec3(0.5, 0.0, -5.0), 0.1), PadInput{}};
  const Solved one = solve(model, pads, 1), two = solve(model, pads, 2);
  REQUIRE(one.report.converged);
  CHECK(std::memcmp(one.state.x.data(), two.state.x.data(), sizeof(double) * one.state.x.size()) == 0);
  CHECK(std::memcmp(one.state.reaction.data(), two.state.reaction.data(), sizeof(double) * one.state.x.size()) == 0);
}

TEST_CASE("a push that no body can follow is reported with place, reason and the last load", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const FemModel model(scene, of_element(element));
  const std::vector<PadInput> pads{posed(scene.pads[0], Vec3(0.0, 0.0, -25.0)), PadInput{}};  // 20 mm is the bottom
  const Solved solved = solve(model, pads);
  CHECK_FALSE(solved.report.converged);
  CHECK(solved.report.load > 0.1);
  CHECK(solved.report.load < 0.8);
  CHECK(solved.report.trouble != FemTrouble::none);
  CHECK(solved.report.trouble_index >= 0);
  CHECK(solved.report.words().find("% of the load") != std::string::npos);
  // What is returned is an equilibrium: its pads are where that share of the way leads.
  const Vec3 corner = solved.state.x.segment<3>(3 * model.pad_nodes()[0][0]);
  const Vec3 rest = scene.mesh.node(model.pad_nodes()[0][0]);
  CHECK((corner - rest - solved.report.load * Vec3(0.0, 0.0, -25.0)).norm() < 1e-9);
  CHECK(solved.report.force_residual < 1e-6);
}

TEST_CASE("numbers and parameters that do not fit are refused", "[fem]") {
  Scene scene = box_scene({2, 2, 1, 10.0});
  FemModel model(scene, of_element(FemElement::p1));
  CHECK_THROWS_AS(model.set_parameter("poissons_ratio", 0.5), ModelError);
  CHECK_THROWS_AS(model.set_parameter("colour", 1.0), ModelError);
  CHECK_THROWS_AS(model.solid().set_stiffness({1.0}), ModelError);
  scene.fixed_surface = "nothing";
  CHECK_THROWS_AS(FemModel(scene, of_element(FemElement::p1)), ModelError);
}
