#include <catch2/catch.hpp>

#include "core/diagnosis/path_solver.hpp"
#include "tests/core/diagnosis/derivative_check.hpp"
#include "tests/core/diagnosis/twin_session.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

PathAnswer answer_of(PathSolver& solver, const LoadPath& path) {
  PathAnswer answer;
  REQUIRE(solver.solve(path, 0, {}, answer));
  return answer;
}

}  // namespace

TEST_CASE("derivatives along a path are those of differences, of what a body remembers, too", "[diagnosis]") {
  const Scene scene = box_scene({3, 3, 2, 12.0});
  const RecordedTrial trial = push_trial(scene, "t", {0}, 4.0, 8.0);
  const LoadPath path(trial, scene, 2.0);
  PathSolver solver(scene, {find_effect("viscoelasticity"), find_effect("inclusion")}, FemElement::p1);
  check_derivatives(solver, path,
                    {{"youngs_modulus", 5.0},
                     {"poissons_ratio", 0.43},
                     {"viscoelasticity.g1", 0.4},
                     {"viscoelasticity.tau1", 0.3},
                     {"inclusion.center.x", 20.0},
                     {"inclusion.center.y", 15.0},
                     {"inclusion.center.z", 10.0},
                     {"inclusion.radius", 9.0},
                     {"inclusion.ratio", 3.0}},
                    1e-2, 0.03);
}

TEST_CASE("an effect that is absent can be tried at many places at once", "[diagnosis]") {
  const Scene scene = box_scene({3, 3, 2, 12.0});
  const RecordedTrial trial = push_trial(scene, "t", {0}, 4.0, 8.0);
  const LoadPath path(trial, scene, 2.0);
  PathSolver solver(scene, {find_effect("inclusion")}, FemElement::p1);
  const std::vector<std::pair<std::string, double>> place{{"inclusion.center.x", 12.0},
                                                          {"inclusion.center.y", 24.0},
                                                          {"inclusion.center.z", 14.0},
                                                          {"inclusion.radius", 8.0}};
  for (const char* name : {"inclusion.center.x", "inclusion.center.y", "inclusion.center.z"})
    solver.set_parameter(name, 0.0);
  solver.set_parameter("inclusion.radius", 5.0);
  solver.set_parameter("inclusion.ratio", 1.0);
  const std::vector<PathParameter> columns{{"inclusion.ratio", 1e-5, place}};
  PathAnswer scanned;
  REQUIRE(solver.solve(path, 0, columns, scanned));
  for (const auto& [name, value] : place) solver.set_parameter(name, value);
  const std::vector<PathParameter> parameters{{"inclusion.ratio", 1e-5, {}}};
  PathAnswer direct;
  REQUIRE(solver.solve(path, 0, parameters, direct));
  CHECK((scanned.by_parameter[0] - direct.by_parameter[0]).norm() < 1e-3 * direct.by_parameter[0].norm());
}

TEST_CASE("a body without memory answers alike there and back", "[diagnosis]") {
  const Scene scene = box_scene({3, 3, 2, 12.0});
  const RecordedTrial trial = push_trial(scene, "t", {1}, 5.0, 8.0);
  const LoadPath path(trial, scene, 2.0);
  PathSolver solver(scene, {}, FemElement::p2);
  const PathAnswer answer = answer_of(solver, path);
  for (std::size_t a = 0; a < path.keys().size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (path.keys()[a].pose == path.keys()[b].pose)
        CHECK((answer.values.row(static_cast<Eigen::Index>(a)) - answer.values.row(static_cast<Eigen::Index>(b)))
                  .norm() == 0.0);
}

TEST_CASE("numbers by which the body folds are given up before they take all the time", "[diagnosis]") {
  const RecordedSession session = twin_session({}, 1);
  const LoadPath path(session.trials[0], session.scene, 3.0);
  PathSolver solver(session.scene, {});
  const double ratio = session.scene.material.poissons_ratio, too_much = 0.4995;
  solver.set_parameter("poissons_ratio", ratio);
  answer_of(solver, path);
  const int usual = solver.corrections();
  CHECK(usual > static_cast<int>(path.keys().size()) / 2);
  PathAnswer answer;
  solver.set_parameter("poissons_ratio", too_much);
  REQUIRE_FALSE(solver.solve(path, 0, {}, answer));
  const int unlimited = solver.corrections();
  solver.set_patience(2 * usual);
  REQUIRE_FALSE(solver.solve(path, 0, {}, answer));
  constexpr int kOfOneStep = 31;
  CHECK(solver.corrections() <= 2 * usual + kOfOneStep);
  CHECK(solver.corrections() < unlimited);
  // What is no harder is solved, whatever was given up before.
  solver.set_parameter("poissons_ratio", ratio - 0.02);
  answer_of(solver, path);
}
