#include <catch2/catch.hpp>

#include "core/diagnosis/search.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;

namespace {

// Channels in turn have these chi squares.
Candidate fitted(const Scene& scene, double log_evidence, const std::vector<double>& chi_square_of_marker) {
  Candidate candidate;
  candidate.exact.solved = true;
  candidate.exact.log_evidence = log_evidence;
  candidate.exact.chi_square_of_channel = Eigen::VectorXd::Zero(channels_of(scene).count());
  for (std::size_t i = 0; i < chi_square_of_marker.size(); ++i)
    candidate.exact.chi_square_of_channel.segment<3>(3 * static_cast<Eigen::Index>(i))
        .setConstant(chi_square_of_marker[i] / 3.0);
  return candidate;
}

}  // namespace

TEST_CASE("what one marker alone says is no evidence, but that it slipped", "[diagnosis]") {
  RecordedSession session;
  session.scene = testing::box_scene({});
  SearchResult result;
  result.exact.session = &session;
  result.numbers = fitted(session.scene, -1000.0, {900.0, 200.0, 200.0});
  const Candidate by_one = fitted(session.scene, -640.0, {200.0, 190.0, 200.0});
  CHECK(advantage(result, by_one) == Approx(360.0 - 350.0));
  const Candidate by_all = fitted(session.scene, -640.0, {660.0, 0.0, -80.0});
  CHECK(advantage(result, by_all) == Approx(360.0 - 140.0));
  Candidate slipped = by_one;
  slipped.hypothesis.slips.emplace_back();
  CHECK(advantage(result, slipped) == Approx(360.0));
  CHECK(advantage(result, result.numbers) == 0.0);
  Candidate unsolved = by_one;
  unsolved.exact.solved = false;
  CHECK(advantage(result, unsolved) < -1e8);
}

TEST_CASE("a rival that linear elements prefer counts until quadratic ones have heard it to its end", "[diagnosis]") {
  Candidate chosen, rival;
  chosen.kinds = {"viscoelasticity", "stiffness-gradient"};
  rival.kinds = {"viscoelasticity", "inclusion"};
  chosen.fast.solved = rival.fast.solved = chosen.exact.solved = true;
  chosen.fast.log_evidence = -200.0;
  rival.fast.log_evidence = -100.0;
  SearchResult result;
  const auto is_doubted = [&] {
    result.rounds = {{Candidate()}, {chosen, rival}};
    return has_unheard_rival(result, result.rounds[1].front());
  };
  CHECK(is_doubted());
  rival.exact.solved = true;
  CHECK_FALSE(is_doubted());
  rival.exact.stopped = true;
  CHECK(is_doubted());
  rival.fast.log_evidence = -300.0;
  CHECK_FALSE(is_doubted());
  CHECK_FALSE(has_unheard_rival(result, result.numbers));
}
