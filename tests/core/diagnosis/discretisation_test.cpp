#include <catch2/catch.hpp>

#include "core/diagnosis/discretisation.hpp"
#include "core/refined_mesh.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;

TEST_CASE("what finer elements say of a push is what they say when they are solved for it", "[diagnosis]") {
  const Scene scene = testing::box_scene({3, 3, 2, 12.0});
  const Channels channels = channels_of(scene);
  const double depth = 5.0;
  for (const double share : {0.5, 1.0}) {
    std::vector<PadInput> whole(scene.pads.size()), part(scene.pads.size());
    for (const auto& [pads, way] : {std::pair{&whole, depth}, std::pair{&part, share * depth}}) {
      (*pads)[0].kind = PadInput::Kind::pose;
      (*pads)[0].center = scene.pads[0].center + way * scene.pads[0].direction;
    }
    Scene fine = scene;
    fine.mesh = refined(scene.mesh).mesh;
    std::array<Eigen::RowVectorXd, 2> seen;
    for (int i = 0; i < 2; ++i) {
      PathSolver solver(i == 0 ? scene : fine, {});
      FemState state = rest_state(solver.model());
      REQUIRE(solve_static(solver.equilibrium(), state, {part, nullptr}, FemControl{1e-5, 30, 2.0, 0.01}).converged);
      seen[i] = solver.observe(state, part);
    }
    const FinerAnswer answer = finer_answer(scene, whole);
    REQUIRE(answer.solved);
    const int seen_count = 3 * (channels.markers + channels.targets);
    const Eigen::RowVectorXd difference = (seen[1] - seen[0]).head(seen_count);
    CHECK(difference.norm() > 0.01);
    CHECK((answer.difference(share).head(seen_count) - difference).norm() < 0.2 * difference.norm());
    const int force = channels.of_force(0);
    CHECK(answer.force_factor(share)[0] ==
          Approx(seen[1].segment<3>(force).norm() / seen[0].segment<3>(force).norm()).margin(0.003));
    CHECK(answer.force_factor(share)[1] == Approx(1.0));
  }
}
