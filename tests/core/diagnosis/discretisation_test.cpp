#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/discretisation.hpp"
#include "core/edge_load.hpp"
#include "core/refined_mesh.hpp"
#include "tests/core/diagnosis/twin_session.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;

namespace {
const std::atomic<bool> kNever{false};
}  // namespace

TEST_CASE("what finer elements say of a push is what they say when they are solved for it", "[diagnosis]") {
  const Scene scene = testing::box_scene({3, 3, 2, 12.0});
  const Channels channels = channels_of(scene);
  const double depth = 5.0;
  for (const double share : {0.5, 0.85, 1.0}) {
    std::vector<PadInput> whole(scene.pads.size()), part(scene.pads.size());
    for (const auto& [pads, way] : {std::pair{&whole, depth}, std::pair{&part, share * depth}}) {
      (*pads)[0].kind = PadInput::Kind::pose;
      (*pads)[0].center = scene.pads[0].center + way * scene.pads[0].direction;
    }
    Scene fine = scene;
    fine.mesh = refined(scene.mesh);
    std::array<Eigen::RowVectorXd, 2> seen;
    for (int i = 0; i < 2; ++i) {
      PathSolver solver(i == 0 ? scene : fine, {});
      FemState state = rest_state(solver.model());
      REQUIRE(solve_static(solver.equilibrium(), state, {part, nullptr}, FemControl{1e-5, 30, 2.0, 0.01}).converged);
      seen[i] = solver.observe(state, part);
    }
    const FinerAnswer answer = finer_answer(scene, {}, whole, kNever, kNever);
    REQUIRE(answer.reached == 1.0);
    const int seen_count = 3 * (channels.markers + channels.targets);
    const Eigen::RowVectorXd difference = (seen[1] - seen[0]).head(seen_count);
    CHECK(difference.norm() > 0.01);
    CHECK((answer.difference(share).head(seen_count) - difference).norm() < 0.03 * difference.norm());
    const int force = channels.of_force(0);
    CHECK(answer.force_factor(share)[0] ==
          Approx(seen[1].segment<3>(force).norm() / seen[0].segment<3>(force).norm()).margin(0.001));
    CHECK(answer.force_factor(share)[1] == Approx(1.0));
  }
}

TEST_CASE("where finer elements fold they count as far as they were solved", "[diagnosis]") {
  const Scene scene = testing::box_scene({2, 2, 2, 12.0});
  const auto pushed = [&](double depth) {
    std::vector<PadInput> pads(scene.pads.size());
    pads[0].kind = PadInput::Kind::pose;
    pads[0].center = scene.pads[0].center + depth * scene.pads[0].direction;
    return finer_answer(scene, {}, pads, kNever, kNever);
  };
  const double deep = 17.0;
  const FinerAnswer folded = pushed(deep);
  REQUIRE(folded.reached > 0.5);
  REQUIRE(folded.reached < 0.8);
  const auto markers = static_cast<Eigen::Index>(3 * scene.markers.size());
  const auto error = [&](double share) {
    const FinerAnswer solved = pushed(share * deep);
    REQUIRE(solved.reached == 1.0);
    const Eigen::RowVectorXd expected = solved.difference(1.0).head(markers);
    return (folded.difference(share).head(markers) - expected).norm() / expected.norm();
  };
  CHECK(error(0.35) < 0.01);
  CHECK(error(folded.reached) < 0.01);
  CHECK(error(0.8) < 0.25);  // extrapolated
}

TEST_CASE("finer elements that are hurried count as far as they came, and say nothing once stopped", "[diagnosis]") {
  const Scene scene = testing::box_scene({3, 3, 2, 12.0});
  std::vector<PadInput> pads(scene.pads.size());
  pads[0].kind = PadInput::Kind::pose;
  pads[0].center = scene.pads[0].center + 5.0 * scene.pads[0].direction;
  const FinerAnswer whole = finer_answer(scene, {}, pads, kNever, kNever);
  REQUIRE(whole.reached == 1.0);
  const std::atomic<bool> now{true};
  CHECK_FALSE(finer_answer(scene, {}, pads, now, kNever).solved());
  CHECK_FALSE(finer_answer(scene, {}, pads, kNever, now).solved());

  // Whenever it is hurried: what is said is right where it was solved.
  const auto markers = static_cast<Eigen::Index>(3 * scene.markers.size());
  for (int after_ms = 1; after_ms < 2000; after_ms *= 2) {
    std::atomic<bool> hurry{false};
    std::thread clock([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(after_ms));
      hurry = true;
    });
    const FinerAnswer part = finer_answer(scene, {}, pads, hurry, kNever);
    clock.join();
    if (!part.solved()) continue;
    const Eigen::RowVectorXd expected = whole.difference(part.reached).head(markers);
    CHECK((part.difference(part.reached).head(markers) - expected).norm() < 0.05 * expected.norm());
  }
}

TEST_CASE("finer elements get no more than their part of the budget", "[diagnosis]") {
  const RecordedSession session = testing::twin_session({}, 1);
  SearchOptions options;
  options.budget = 1e4;
  Work work(options);
  FitData data = fit_data(session, 3.0, FemElement::p2, error_model(session), &work.stop);
  CHECK_FALSE(Allotment(work, 1.0).over);
  CHECK(Allotment(work, 0.0).over);
  const FinerJudgement none = correct_by_finer({}, work, 0.0, data);
  CHECK(none.hurried);
  CHECK(none.judged() == 0);
  CHECK_FALSE(work.over());
  const FinerJudgement all = correct_by_finer({}, work, 1.0, data);
  CHECK_FALSE(all.hurried);
  CHECK(all.judged() == 3);
  // Nor more than that where they take longer.
  SearchOptions brief;
  brief.budget = 0.02;
  Work hardly(brief);
  FitData hurried = fit_data(session, 3.0, FemElement::p2, error_model(session), &hardly.stop);
  CHECK(correct_by_finer({}, hardly, 0.5, hurried).hurried);
}

TEST_CASE("what elements err at rest shrinks with their size", "[diagnosis]") {
  Scene scene = testing::box_scene({2, 2, 4, 10.0});
  scene.pads.clear();
  scene.gravity = {1.0, 0.0, 0.0};
  const EdgeLoad load{{Vec3(0.0, 0.0, 40.0), Vec3(0.0, 20.0, 40.0)}, {0.01, 0.0, 0.0}, 0.0};
  const auto coarse = finer_rest(scene, {&load, 1});
  scene.mesh = refined(scene.mesh);
  const auto fine = finer_rest(scene, {&load, 1});
  REQUIRE(coarse);
  REQUIRE(fine);
  CHECK(*coarse > 1e-4);
  CHECK(*fine < 0.6 * *coarse);
  scene.mesh = refined(scene.mesh);
  CHECK_FALSE(finer_rest(scene, {&load, 1}));  // too many elements
}
