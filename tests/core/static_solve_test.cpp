// solve_static against Newton's method on the same energy, and what it says when it cannot.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "core/static_solve.hpp"
#include "tests/core/newton_twin.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr BoxSize kSmall{3, 2, 2, 10.0};

PadInput pushed(const Pad& pad, const Vec3& way, double turn = 0.0) {
  PadInput input;
  input.kind = PadInput::Kind::pose;
  input.center = pad.center + way;
  input.rotation = Eigen::AngleAxisd(turn, Vec3::UnitX()).toRotationMatrix();
  return input;
}

StaticOptions fine() {
  StaticOptions options;
  options.element = Element::p1;
  options.tolerance = 3e-9;
  options.threads = 1;
  return options;
}

void check_against_twin(const Scene& scene, const std::vector<PadInput>& pads) {
  const TwinAnswer twin = solve_by_newton(scene, pads, external_forces(scene, pads), 4);
  REQUIRE(twin.unbalanced < 1e-8);
  const StaticSolution solution = solve_static(scene, pads, fine());
  INFO(solution.trouble);
  REQUIRE(solution.converged);
  CHECK((solution.positions - twin.positions).rowwise().norm().maxCoeff() < 1e-6);
  CHECK(solution.inverted == 0);
  CHECK(solution.force_residual < 1e-6);
  for (std::size_t p = 0; p < pads.size(); ++p) {
    Vec3 force = Vec3::Zero();
    if (pads[p].kind == PadInput::Kind::pose)
      for (int node : nodes_of(*scene.mesh.find_surface(scene.pads[p].surface))) force += twin.reactions[node];
    CHECK((solution.pad_forces[p] - force).norm() < 1e-5);
  }
}

}  // namespace

TEST_CASE("a static push is where Newton's method finds it", "[static_solve]") {
  const Scene scene = box_scene(kSmall);
  check_against_twin(scene, {pushed(scene.pads[0], Vec3(0.5, 0.3, -4.0), 0.1), PadInput{}});
}

TEST_CASE("a static pull is where Newton's method finds it", "[static_solve]") {
  const Scene scene = box_scene(kSmall);
  check_against_twin(scene, {PadInput{}, pushed(scene.pads[1], Vec3(0.0, 1.0, 3.0))});
}

TEST_CASE("static sag under gravity is where Newton's method finds it", "[static_solve]") {
  Scene scene = box_scene(kSmall);
  scene.gravity = Vec3(0.3, 0.0, -1.0);
  check_against_twin(scene, {PadInput{}, PadInput{}});
}

TEST_CASE("a pad's force in a static solve is spread by area", "[static_solve]") {
  const Scene scene = box_scene(kSmall);
  PadInput push;
  push.kind = PadInput::Kind::force;
  push.force = Vec3(0.02, 0.0, -0.15);
  check_against_twin(scene, {push, PadInput{}});
}

TEST_CASE("small pushes are reciprocal", "[static_solve]") {
  const Scene scene = box_scene(kSmall);
  // Work of one pad's force on the other's displacement, shares as in the force's spreading.
  const auto coupling = [&](int by, int on) {
    std::vector<PadInput> pads(2), weights(2);
    pads[by].kind = weights[on].kind = PadInput::Kind::force;
    pads[by].force = Vec3(0.0, 0.0, -1e-3);
    weights[on].force = Vec3(0.0, 0.0, -1e-3);
    NodeField moved = solve_static(scene, pads, fine()).positions;
    moved.leftCols<3>() -= scene.mesh.rest;
    return moved.cwiseProduct(external_forces(scene, weights)).sum();
  };
  const double there = coupling(0, 1), back = coupling(1, 0);
  CHECK(there > 0.0);
  CHECK(there == Approx(back).epsilon(5e-3));
}

TEST_CASE("a static solve that has not converged says so", "[static_solve]") {
  const Scene scene = box_scene(kSmall);
  StaticOptions options = fine();
  options.max_iterations = 3;
  const StaticSolution solution =
      solve_static(scene, std::vector<PadInput>{pushed(scene.pads[0], Vec3(0, 0, -4)), {}}, options);
  CHECK(!solution.converged);
  CHECK(solution.iterations <= 3);
  CHECK(solution.residual > options.tolerance);
  CHECK(solution.trouble.find("not converged") != std::string::npos);
}
