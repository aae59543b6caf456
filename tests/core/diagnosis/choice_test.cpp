#include "core/diagnosis/choice.hpp"

#include <catch2/catch.hpp>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;

namespace {

// Of kinds, with that advantage over numbers alone, and markers' residuals of so many mm.
Candidate fitted(const Scene& scene, std::vector<std::string> kinds, double advantage, double misfit_mm) {
  Candidate candidate;
  candidate.kinds = std::move(kinds);
  candidate.exact.solved = true;
  candidate.exact.log_evidence = advantage;
  const Eigen::Index channels = channels_of(scene).count();
  candidate.exact.chi_square_of_channel = Eigen::VectorXd::Zero(channels);
  TrialResidual trial;
  // Of either sign in turn: not a constant, which would be where markers sit.
  trial.residual = RowMatrix::Constant(4, channels, misfit_mm);
  trial.residual.row(1) *= -1.0;
  trial.residual.row(3) *= -1.0;
  trial.load = Eigen::VectorXd::Zero(4);
  candidate.exact.residuals = {trial};
  return candidate;
}

struct Search {
  RecordedSession session;
  SearchResult result;

  Search() {
    session.scene = testing::box_scene({});
    const Eigen::Index channels = channels_of(session.scene).count();
    result.exact.session = &session;
    result.exact.errors.noise = Eigen::VectorXd::Constant(channels, 0.1);
    result.exact.errors.offset = Eigen::VectorXd::Constant(channels, 0.2);
    result.exact.errors.discretisation = RowMatrix::Constant(1, channels, 0.05);
    result.discretisation_mm = 0.05;
    result.numbers = fitted({}, 0.0, 0.3);
  }
  Candidate fitted(std::vector<std::string> kinds, double advantage, double misfit_mm) const {
    return ::fitted(session.scene, std::move(kinds), advantage, misfit_mm);
  }
};

}  // namespace

TEST_CASE("what gains too little, or takes off less than elements err, is not believed", "[diagnosis]") {
  Search search;
  const auto chosen_with = [&](double advantage, double misfit_mm) {
    search.result.rounds = {{search.fitted({"gravity"}, advantage, misfit_mm)}};
    return chosen_of(search.result).name();
  };
  CHECK(chosen_with(kAccept + 1.0, 0.2) == "gravity");
  CHECK(chosen_with(kAccept - 1.0, 0.2) == "parameters");
  CHECK(chosen_with(kAccept + 1.0, 0.297) == "parameters");
}

TEST_CASE("a pair is believed whose first half shows itself only beside the second", "[diagnosis]") {
  Search search;
  const Candidate first = search.fitted({"viscoelasticity"}, 300.0, 0.299);
  const Candidate pair = search.fitted({"viscoelasticity", "stiffness-gradient"}, 2000.0, 0.1);
  search.result.rounds = {{first}, {pair}};
  const Candidate& chosen = chosen_of(search.result);
  CHECK(chosen.name() == "viscoelasticity + stiffness-gradient");
  const Weights weights = weigh(search.result, chosen);
  CHECK(probability_of("viscoelasticity", weights) == kSurest);
  CHECK(probability_of("stiffness-gradient", weights) == kSurest);
  CHECK(probability_of("gravity", weights) == Approx(1.0 - kSurest));

  // Nor is a weak second half believed for what the first one gained.
  search.result.rounds = {{first}, {search.fitted(pair.kinds, 300.0 + kAcceptBeside - 1.0, 0.1)}};
  CHECK(chosen_of(search.result).name() == "parameters");
  search.result.rounds = {{search.fitted({"viscoelasticity"}, 300.0, 0.2)},
                          {search.fitted(pair.kinds, 300.0 + kAcceptBeside - 1.0, 0.1)}};
  CHECK(chosen_of(search.result).name() == "viscoelasticity");
}

TEST_CASE("a latency is believed by its evidence, however little it takes off", "[diagnosis]") {
  Search search;
  const auto chosen_with = [&](const Candidate& first, std::vector<std::string> kinds, double advantage) {
    Candidate last = search.fitted(std::move(kinds), advantage, 0.198);
    last.hypothesis.latency = true;
    search.result.rounds = {{first}, {last}};
    return chosen_of(search.result).name();
  };
  const Candidate fibres = search.fitted({"anisotropy"}, 300.0, 0.2);
  CHECK(chosen_with(fibres, {"anisotropy", "latency"}, 300.0 + kAcceptBeside + 1.0) == "anisotropy + latency");
  CHECK(chosen_with(fibres, {"anisotropy", "latency"}, 300.0 + kAcceptBeside - 1.0) == "anisotropy");
  // Where the latency is not what was added, all else is to take off more than elements err.
  Candidate latency = search.fitted({"latency"}, 300.0, 0.2);
  latency.hypothesis.latency = true;
  CHECK(chosen_with(latency, {"latency", "anisotropy"}, 300.0 + kAcceptBeside + 1.0) == "latency");
}

TEST_CASE("a pair that quadratic elements had no time for is not believed", "[diagnosis]") {
  Search search;
  Candidate pair = search.fitted({"gravity", "latency"}, 2000.0, 0.1);
  std::swap(pair.fast, pair.exact);
  search.result.rounds = {{search.fitted({"gravity"}, 300.0, 0.2)}, {pair}};
  CHECK(chosen_of(search.result).name() == "gravity");
}

TEST_CASE("rivals share the probability by their advantages", "[diagnosis]") {
  Search search;
  search.result.rounds = {{search.fitted({"gravity"}, 100.0, 0.2), search.fitted({"latency"}, 100.0, 0.2)}};
  const Weights weights = weigh(search.result, chosen_of(search.result));
  CHECK(probability_of("gravity", weights) == Approx(0.5).margin(1e-4));
  search.result.rounds[0][1].exact.log_evidence -= kTemperature * std::log(3.0);
  CHECK(probability_of("gravity", weigh(search.result, chosen_of(search.result))) == Approx(0.75).margin(1e-4));
}
