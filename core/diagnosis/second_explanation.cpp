#include "core/diagnosis/second_explanation.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/discretisation.hpp"
#include "core/diagnosis/narrowing.hpp"

namespace tissued::core {

namespace {

constexpr std::size_t kMostPairs = 2;

// What the candidate's effect is nothing without differs from nothing beyond 95 %. True where nothing is known of that.
bool is_beyond_doubt(const Candidate& candidate, const Fit& fit, const Scene& scene) {
  constexpr std::array<double, 4> kChiSquare{0.0, 3.84, 5.99, 7.81};  // 95 % of so many
  if (candidate.hypothesis.effects.empty()) return true;
  const Effect& effect = *candidate.hypothesis.effects.back();
  const std::vector<double> neutral = effect.neutral(scene);
  std::vector<Eigen::Index> at;
  std::vector<double> off;
  for (const int k : effect.amplitudes())
    for (std::size_t j = 0; j < fit.unknowns.size(); ++j) {
      if (fit.unknowns[j].name != model_parameter(effect, effect.parameters()[k])) continue;
      Unknown nothing = fit.unknowns[j];
      nothing.value = neutral[static_cast<std::size_t>(k)];
      at.push_back(static_cast<Eigen::Index>(j));
      off.push_back(fit.unknowns[j].fitted() - nothing.fitted());
    }
  if (at.empty() || at.size() >= kChiSquare.size()) return true;
  Eigen::MatrixXd covariance = fit.covariance;
  // Without forces only what is in proportion to the modulus is known, but that well.
  for (std::size_t j = 0; j < fit.unknowns.size(); ++j) {
    if (fit.unknowns[j].name != "youngs_modulus") continue;
    const auto c = static_cast<Eigen::Index>(j);
    covariance -= (covariance.col(c) * covariance.row(c) / covariance(c, c)).eval();
  }
  const Eigen::MatrixXd own = kTemperature * covariance(at, at);
  const Eigen::Map<const Eigen::VectorXd> way(off.data(), static_cast<Eigen::Index>(off.size()));
  return !(way.dot(own.llt().solve(way)) < kChiSquare[at.size()]);
}

// Of pairs that were looked for before nothing is left.
void find_second(Work& work, SearchResult& result) {
  result.rounds.resize(1);
  const Candidate first = result.rounds[0].front();
  FitData coarse = result.coarse, fast = result.fast;
  work.all(
      2, [&](std::size_t job) { rebase(result.exact, first.exact, job == 0 ? fast : coarse); }, 0.6, 0.62,
      [](std::size_t) { return "a second explanation"; });
  std::vector<Candidate> pairs;
  for (std::size_t i = 1; i < result.rounds[0].size(); ++i) {
    const Candidate& second = result.rounds[0][i];
    if (!second.fast.solved) continue;
    pairs.push_back(extended(first, second));
    // Where each place takes a solve of its own, those that were best alone.
    const bool has_amplitude = second.hypothesis.effects.empty() || second.hypothesis.effects.back()->amplitude() >= 0;
    if (!has_amplitude && second.promises.size() > kStartsToFit) {
      std::vector<Values> starts;
      for (std::size_t k = 0; k < kStartsToFit; ++k) starts.push_back(pairs.back().starts[second.promises[k].start]);
      pairs.back().starts = std::move(starts);
    }
  }
  if (pairs.empty()) return;
  if (Narrowing(coarse, fast, result.exact, first, work).run(pairs, kMostPairs, 0.62, 1.0)) {
    result.rounds.push_back(std::move(pairs));
  } else {
    say_untried("a second explanation", work, result);
  }
}

// Elements err differently beside the first explanation than where they were judged: where a second one would be said,
// that must not be what it explains.
void judge_second(const SearchOptions& options, Work& work, SearchResult& result) {
  constexpr double kMostOfBudget = 0.85;
  Candidate &first = result.rounds[0].front(), &second = result.rounds[1].front();
  if (!options.refine_mesh || result.exact.session->scene.mesh.tet_count() > kMostRefinedTets) return;
  if (!second.exact.solved || gain(result, second, first) < kAcceptBeside || work.over()) return;
  FitData data = result.exact;
  const FinerJudgement judgement = correct_by_finer(first.exact, work, kMostOfBudget, data);
  if (judgement.judged() == 0) return;
  const int threads = std::exchange(data.threads, work.threads());
  const std::array<Candidate*, 3> judged{&first, &second, &result.numbers};
  std::array<Fit, 3> again;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    again[i] = fit(data, judged[i]->hypothesis, values_of(judged[i]->exact), kExact);
    if (judged[i] != &result.numbers) shed(again[i]);
    if (work.over() || !again[i].solved) return;
  }
  // What was not fitted again keeps its distance: a pair from the pair that was, all else from numbers alone.
  const auto follow = [](std::vector<Candidate>& round, const Fit& now, const Fit& before) {
    const double evidence = now.log_evidence - before.log_evidence;
    const Eigen::VectorXd chi_square = now.chi_square_of_channel - before.chi_square_of_channel;
    for (Candidate& candidate : round) {
      if (!candidate.exact.solved) continue;
      candidate.exact.log_evidence += evidence;
      candidate.exact.chi_square_of_channel += chi_square;
    }
  };
  follow(result.rounds[0], again[2], result.numbers.exact);
  follow(result.rounds[1], again[1], second.exact);
  for (std::size_t i = 0; i < judged.size(); ++i) judged[i]->exact = std::move(again[i]);
  data.threads = threads;
  result.exact = std::move(data);
  result.discretisation_mm = judgement.rms_mm;
}

}  // namespace

bool refit_halves(Work& work, SearchResult& result) {
  std::vector<Candidate>& singles = result.rounds[0];
  Candidate& pair = result.rounds[1].front();
  if (!pair.exact.solved || gain(result, pair, singles.front()) < kAcceptBeside) return false;
  const auto second = std::find_if(singles.begin() + 1, singles.end(),
                                   [&](const Candidate& single) { return single.kinds.front() == pair.kinds.back(); });
  const std::array<Candidate*, 2> halves{&singles.front(), &*second};
  const Values values = values_of(pair.exact);
  std::array<Fit, 2> alone;
  if (work.over()) {
    for (std::size_t i = 0; i < halves.size(); ++i)
      if (!is_beyond_doubt(*halves[1 - i], pair.exact, result.exact.session->scene))
        alone[i] = assess_unhurried(result.exact, halves[i]->hypothesis, values);
    if (!alone[0].solved && !alone[1].solved) return false;
    pair.exact = Fit();
  } else {
    work.all(
        halves.size(), [&](std::size_t i) { alone[i] = fit(result.exact, halves[i]->hypothesis, values, kExact); },
        0.95, 1.0, [&](std::size_t i) { return "looking closely at " + halves[i]->name(); });
  }
  for (std::size_t i = 0; i < halves.size(); ++i) {
    shed(alone[i]);
    const bool is_better = !halves[i]->exact.solved || alone[i].log_evidence > halves[i]->exact.log_evidence;
    if (alone[i].solved && is_better) halves[i]->exact = std::move(alone[i]);
  }
  const bool leads = gain(result, *second, singles.front()) > 0.0;
  if (leads) std::rotate(singles.begin(), second, second + 1);
  return leads && gain(result, pair, singles.front()) < kAcceptBeside;
}

void explain_further(const SearchOptions& options, Work& work, SearchResult& result) {
  constexpr int kMostLeads = 2;
  for (int lead = 0; lead < kMostLeads && !work.over(); ++lead) {
    find_second(work, result);
    if (result.rounds.size() < 2) return;
    if (!refit_halves(work, result)) break;
  }
  if (result.rounds.size() > 1) judge_second(options, work, result);
}

}  // namespace tissued::core
