#include "core/diagnosis/search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/discretisation.hpp"
#include "core/diagnosis/motion_search.hpp"
#include "core/diagnosis/narrowing.hpp"
#include "core/diagnosis/second_explanation.hpp"

namespace tissued::core {

namespace {

constexpr double kTravel = 3.0, kCoarseTravel = 5.0;  // mm between keys
constexpr std::size_t kMostExact = 4;

// Other numbers alone bring the markers about down to noise: then it is as well to judge elements where these are.
bool nearly_explains(const FitData& data, const Fit& numbers) {
  constexpr double kNearly = 2.0;
  if (!numbers.solved) return false;
  const Channels channels = channels_of(data.session->scene);
  return structure_left(data.errors, channels, pointers_to(numbers.residuals))[0] < kNearly;
}

void say_unjudged(const FinerJudgement& judgement, SearchResult& result) {
  if (judgement.judged() < judgement.reached.size())
    result.remarks.push_back("What the elements err was judged in " + std::to_string(judgement.judged()) + " of " +
                             std::to_string(judgement.reached.size()) + " recordings with a push.");
  double least = 1.0;
  for (const double reached : judgement.reached)
    if (reached > 0.0) least = std::min(least, reached);
  if (least < 1.0)
    result.remarks.push_back("Finer elements were solved up to " + std::to_string(std::lround(100.0 * least)) +
                             " % of a push: what the elements err beyond is extrapolated.");
}

// The elements' own error, by finer ones: where the numbers are if these may explain all that is seen, else where they
// are assumed to be. What elements err depends on Poisson's ratio more than on anything else.
void correct_elements(const RecordedSession& session, Work& work, SearchResult& result) {
  constexpr double kMostOfBudget = 0.5;
  constexpr double kUnjudged = 0.1;  // mm
  if (session.scene.mesh.tet_count() > kMostRefinedTets) {
    result.unjudged_mm = kUnjudged;
    result.remarks.push_back("What the elements err was not judged: the mesh has more than " +
                             std::to_string(kMostRefinedTets) + " tetrahedra.");
    return;
  }
  const Fit& numbers = result.numbers.fast;
  const FinerJudgement judgement =
      correct_by_finer(nearly_explains(result.fast, numbers) ? numbers : Fit(), work, kMostOfBudget, result.exact);
  say_unjudged(judgement, result);
  result.complete = !judgement.hurried;
  result.discretisation_mm = judgement.rms_mm;
  if (judgement.judged() == 0 && !judgement.reached.empty()) result.unjudged_mm = kUnjudged;
  result.fast.errors = result.exact.errors;
}

// Candidates are compared by linear elements first: those are to answer as quadratic ones do where numbers are.
void rebase_on_numbers(Work& work, SearchResult& result) {
  work.all(
      2, [&](std::size_t job) { rebase(result.exact, result.numbers.exact, job == 0 ? result.fast : result.coarse); },
      0.25, 0.3, [](std::size_t) { return "the assumed physics"; });
  Fit again = fit(result.fast, result.numbers.hypothesis, values_of(result.numbers.exact), kFast);
  if (again.solved) result.numbers.fast = std::move(again);
}

// Where numbers that are far off let the body buckle, stiffer elements may still answer as assumed. All else is
// compared with other numbers: whether the assumed ones have an answer decides nothing.
void assess_by_linear(const Hypothesis& nothing, SearchResult& result) {
  Fit linear = assess_unhurried(result.fast, nothing);
  if (!linear.solved) return;
  result.remarks.push_back("As assumed the body has no equilibrium on the way (" + result.assumed.trouble +
                           "): what is said of it as assumed is by linear elements.");
  result.assumed = std::move(linear);
}

// The assumed physics by all models, and its numbers refitted.
void assess_assumed(const RecordedSession& session, const SearchOptions& options, Work& work, SearchResult& result) {
  const ErrorModel errors = error_model(session);
  result.exact = fit_data(session, kTravel, FemElement::p2, errors, &work.stop);
  result.fast = fit_data(session, kTravel, FemElement::p1, errors, &work.stop);
  result.coarse = fit_data(session, kCoarseTravel, FemElement::p1, errors, &work.stop);
  work.tell(0.02, "the assumed physics");
  work.all(
      2,
      [&](std::size_t job) {
        place_markers(job == 0 ? result.exact : result.coarse);
        correct_by_quadratic(job == 0 ? result.fast : result.coarse);
      },
      0.02, 0.05, [](std::size_t) { return "where markers sit"; });
  result.fast.placement = result.exact.placement;
  result.fast.errors = result.exact.errors;
  result.numbers = numbers_candidate();
  result.numbers.fast = fit(result.fast, result.numbers.hypothesis, {}, kFast);
  if (options.refine_mesh) correct_elements(session, work, result);
  Hypothesis nothing;
  nothing.numbers = false;
  work.all(
      2,
      [&](std::size_t job) {
        if (job == 0) result.assumed = assess(result.exact, nothing);
        if (job == 1)
          result.numbers.exact = fit(result.exact, result.numbers.hypothesis, values_of(result.numbers.fast), kExact);
      },
      0.2, 0.25, [](std::size_t) { return "the assumed physics"; });
  if (!result.assumed.solved && work.over()) result.assumed = assess_unhurried(result.exact, nothing);
  if (!result.assumed.solved) assess_by_linear(nothing, result);
  shed(result.assumed);
  if (nearly_explains(result.exact, result.numbers.exact)) rebase_on_numbers(work, result);
  if (result.numbers.best().solved) return;
  result.numbers.hypothesis = nothing;
  result.numbers.exact = result.assumed;
}

}  // namespace

SearchResult search(const RecordedSession& session, const SearchOptions& options) {
  if (session.is_dynamic()) return search_motion(session, options);
  Work work(options);
  SearchResult result;
  assess_assumed(session, options, work, result);
  if (result.numbers.fast.solved) {
    std::vector<Candidate> singles = single_candidates(session, result.fast, result.numbers.fast);
    // The long ones first: the threads end together.
    std::stable_sort(singles.begin(), singles.end(), [](const Candidate& a, const Candidate& b) {
      const auto weight = [](const Candidate& c) {
        const bool has_history = !c.hypothesis.effects.empty() && c.hypothesis.effects.front()->has_history();
        return c.starts.size() * (has_history ? 10 : 1);
      };
      return weight(a) > weight(b);
    });
    if (!Narrowing(result.coarse, result.fast, result.exact, result.numbers, work).run(singles, kMostExact, 0.3, 0.6))
      say_untried("an explanation", work, result);
    // By what they are accepted by, and not by what a single marker may say.
    const auto judged = std::find_if(singles.begin(), singles.end(), [](const auto& c) { return !c.exact.solved; });
    std::stable_sort(singles.begin(), judged, [&](const Candidate& a, const Candidate& b) {
      return advantage(result, a) > advantage(result, b);
    });
    const bool has_first =
        !singles.empty() && singles.front().exact.solved && advantage(result, singles.front()) >= kAccept;
    result.rounds.push_back(std::move(singles));
    if (has_first) explain_further(options, work, result);
  }
  result.complete = result.complete && !work.stop;
  for (FitData* data : {&result.coarse, &result.fast, &result.exact}) data->stop = nullptr;  // it was this search's
  return result;
}

namespace {

// Of chi square, by the marker that gains most.
double largest_gain_of_marker(const Fit& with, const Fit& without, const Channels& channels) {
  double largest = 0.0;
  for (int i = 0; i < channels.markers; ++i) {
    const auto change = [&](int c) { return without.chi_square_of_channel[c] - with.chi_square_of_channel[c]; };
    const int c = channels.of_marker(i);
    largest = std::max(largest, change(c) + change(c + 1) + change(c + 2));
  }
  return largest;
}

}  // namespace

double gain(const SearchResult& result, const Candidate& with, const Candidate& without) {
  const bool exact = !result.compares_fast && with.exact.solved && without.exact.solved;
  const Fit& base = exact ? without.exact : without.fast;
  const Fit& fit = exact ? with.exact : with.fast;
  if (!fit.solved || !base.solved) return -1e9;
  const double all = fit.log_evidence - base.log_evidence;
  if (!with.hypothesis.slips.empty() && without.hypothesis.slips.empty()) return all;  // what single markers did
  return all - 0.5 * largest_gain_of_marker(fit, base, channels_of(result.exact.session->scene));
}

double advantage(const SearchResult& result, const Candidate& candidate) {
  return &candidate == &result.numbers ? 0.0 : gain(result, candidate, result.numbers);
}

bool has_unheard_rival(const SearchResult& result, const Candidate& chosen) {
  if (chosen.kinds.empty() || chosen.kinds.size() > result.rounds.size()) return false;
  const std::vector<Candidate>& round = result.rounds[chosen.kinds.size() - 1];
  return std::any_of(round.begin(), round.end(), [&](const Candidate& rival) {
    return (!rival.exact.solved || rival.exact.stopped) && rival.fast.solved &&
           rival.fast.log_evidence > chosen.fast.log_evidence;
  });
}

}  // namespace tissued::core
