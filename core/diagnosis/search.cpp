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

namespace tissued::core {

namespace {

constexpr double kTravel = 3.0, kCoarseTravel = 5.0;  // mm between keys
constexpr FitControl kFirstLook{4, 10.0}, kFast{16, 3.0}, kExact{12, 0.5};
constexpr std::size_t kMostFast = 6, kMostExact = 4, kMostPairs = 2, kStartsToFit = 3;
constexpr double kPromised = 10.0;                 // of chi square: with less in one linear step, one look is enough
constexpr double kPromisedBeside = 1.5 * kAccept;  // likewise beside another effect, of the twice kAccept it takes
constexpr double kNear = 0.3;        // of the largest advantage: candidates with less are not looked at more closely
constexpr double kPromising = 0.1;   // likewise, after the first look
constexpr double kWorthExact = 8.0;  // advantage below which a candidate is not looked at more closely

// A first look at a candidate: a few steps on few keys, from the most promising of its starts.
void look_at(const FitData& coarse, Candidate& candidate) {
  std::vector<Values> starts = candidate.starts;
  FitControl control = kFirstLook;
  if (starts.size() > 1) {
    candidate.promises = most_promising(coarse, candidate.hypothesis, starts);
    starts.clear();
    if (!candidate.promises.empty() && candidate.promises.front().gain < kPromised) control.most_evaluations = 1;
    const std::size_t most = control.most_evaluations == 1 ? 1 : kStartsToFit;
    for (const Promise& promise : candidate.promises) {
      if (starts.size() == most || promise.gain < kNear * candidate.promises.front().gain) break;
      starts.push_back(candidate.starts[promise.start]);
      set_amplitude(*candidate.hypothesis.effects.back(), promise.amplitude, starts.back());
    }
  }
  for (const Values& start : starts) {
    Fit tried = fit(coarse, candidate.hypothesis, start, control);
    if (!tried.solved) {
      if (!candidate.fast.solved) candidate.fast.trouble = tried.trouble;
      continue;
    }
    if (!candidate.fast.solved || tried.log_evidence > candidate.fast.log_evidence) candidate.fast = std::move(tried);
  }
}

// What plots do not need of the candidates that lost.
void shed(Fit& fit) {
  for (TrialResidual& trial : fit.residuals) trial.derivatives.clear();
}

bool better(const Candidate& a, const Candidate& b) {
  if (a.exact.solved != b.exact.solved) return a.exact.solved;
  return a.best().log_evidence > b.best().log_evidence;
}

// Ever fewer candidates by ever better models, against what the base of them all reaches.
class Narrowing {
 public:
  // base: evidence by linear elements on few and on all keys of what every candidate adds to.
  Narrowing(const FitData& coarse, const FitData& fast, const FitData& exact, const Candidate& base, Work& work)
      : coarse_(&coarse), fast_(&fast), exact_(&exact), base_(&base), work_(&work) {
    const Values values = values_of(base.best());
    const FitControl control{3, 3.0};
    const Fit on_coarse = fit(coarse, base.hypothesis, values, control),
              on_fast = fit(fast, base.hypothesis, values, control);
    has_base_ = on_coarse.solved && on_fast.solved;
    on_coarse_ = on_coarse.log_evidence;
    on_fast_ = on_fast.log_evidence;
  }

  // False, and nothing is tried, where linear elements have no answer to what every candidate adds to.
  bool run(std::vector<Candidate>& candidates, std::size_t most_exact, double from, double to) {
    if (!has_base_) return false;
    const double first = from + 0.35 * (to - from), second = from + 0.6 * (to - from);
    work_->all(
        candidates.size(),
        [&](std::size_t i) {
          look_at(*coarse_, candidates[i]);
          candidates[i].fast.log_evidence += on_fast_ - on_coarse_;
          shed(candidates[i].fast);
        },
        from, first, [&](std::size_t i) { return "trying " + candidates[i].name(); });
    const std::vector<Candidate*> promising = best_of(candidates, kMostFast, kPromising);
    work_->all(
        promising.size(),
        [&](std::size_t i) {
          Fit tried = fit(*fast_, promising[i]->hypothesis, values_of(promising[i]->fast), kFast);
          shed(tried);
          if (tried.solved) promising[i]->fast = std::move(tried);
        },
        first, second, [&](std::size_t i) { return "fitting " + promising[i]->name(); });
    std::vector<Candidate*> chosen = best_of(candidates, most_exact, kNear);
    // Linear elements err more beside an effect than where nothing is missing.
    if (!base_->kinds.empty()) keep_promising(chosen, second, 0.5 * (second + to));
    FitData data = *exact_;
    if (chosen.size() == 1) data.threads = work_->threads();
    work_->all(
        chosen.size(),
        [&](std::size_t i) {
          chosen[i]->exact = fit(data, chosen[i]->hypothesis, values_of(chosen[i]->fast), kExact);
          shed(chosen[i]->exact);
        },
        second, to, [&](std::size_t i) { return "looking closely at " + chosen[i]->name(); });
    std::stable_sort(candidates.begin(), candidates.end(), better);
    return true;
  }

 private:
  // By quadratic elements, those that may add to the base what it takes to be said.
  void keep_promising(std::vector<Candidate*>& chosen, double from, double to) {
    std::vector<double> promised(chosen.size(), 0.0);
    work_->all(
        chosen.size(),
        [&](std::size_t i) {
          promised[i] = promise_beside(*exact_, *base_, *chosen[i]);
          shed(chosen[i]->exact);
        },
        from, to, [&](std::size_t i) { return "looking closely at " + chosen[i]->name(); });
    std::vector<Candidate*> kept;
    for (std::size_t i = 0; i < chosen.size(); ++i)
      if (promised[i] > kPromisedBeside) kept.push_back(chosen[i]);
    chosen = std::move(kept);
  }

  // Those worth more work: at most so many, with this share of the largest advantage.
  std::vector<Candidate*> best_of(std::vector<Candidate>& candidates, std::size_t most, double share) const {
    std::vector<Candidate*> order;
    for (Candidate& candidate : candidates)
      if (candidate.fast.solved && candidate.fast.log_evidence > on_fast_ + kWorthExact) order.push_back(&candidate);
    std::stable_sort(order.begin(), order.end(), [](const Candidate* a, const Candidate* b) {
      return a->fast.log_evidence > b->fast.log_evidence;
    });
    while (!order.empty() && (order.size() > most || order.back()->fast.log_evidence - on_fast_ <
                                                         share * (order.front()->fast.log_evidence - on_fast_)))
      order.pop_back();
    return order;
  }

  const FitData *coarse_, *fast_, *exact_;
  const Candidate* base_;
  Work* work_;
  bool has_base_ = false;
  double on_coarse_ = 0.0, on_fast_ = 0.0;
};

// Other numbers alone bring the markers about down to noise: then it is as well to judge elements where these are.
bool nearly_explains(const FitData& data, const Fit& numbers) {
  constexpr double kNearly = 2.0;
  if (!numbers.solved) return false;
  const Channels channels = channels_of(data.session->scene);
  return structure_left(data.errors, channels, pointers_to(numbers.residuals))[0] < kNearly;
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
  if (judgement.judged < judgement.pushed)
    result.remarks.push_back("What the elements err was judged in " + std::to_string(judgement.judged) + " of " +
                             std::to_string(judgement.pushed) + " recordings with a push.");
  result.complete = !judgement.hurried;
  result.discretisation_mm = judgement.rms_mm;
  if (judgement.judged == 0 && judgement.pushed > 0) result.unjudged_mm = kUnjudged;
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

// What all else is judged by is had in any case, out of time or not.
Fit assess_unhurried(FitData data, const Hypothesis& hypothesis) {
  data.stop = nullptr;
  return assess(data, hypothesis);
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

void say_untried(const char* what, const Work& work, SearchResult& result) {
  if (work.stop) return;  // which is said anyway
  result.complete = false;
  result.remarks.push_back(std::string("Linear elements find no equilibrium where ") + what +
                           " was to be looked for: it was not.");
}

void find_second(Work& work, SearchResult& result) {
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
  if (!second.exact.solved || gain(result, second, first) < kAccept || work.over()) return;
  FitData data = result.exact;
  const double discretisation = correct_by_finer(first.exact, work, kMostOfBudget, data).rms_mm;
  const int threads = std::exchange(data.threads, work.threads());
  const std::array<Candidate*, 3> judged{&first, &second, &result.numbers};
  std::array<Fit, 3> again;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    again[i] = fit(data, judged[i]->hypothesis, values_of(judged[i]->exact), kExact);
    if (judged[i] != &result.numbers) shed(again[i]);
    if (work.over() || !again[i].solved) return;
  }
  // What was not fitted again keeps its advantage over numbers alone.
  const double shift = again[2].log_evidence - result.numbers.exact.log_evidence;
  for (std::vector<Candidate>& round : result.rounds)
    for (Candidate& candidate : round) candidate.exact.log_evidence += shift;
  for (std::size_t i = 0; i < judged.size(); ++i) judged[i]->exact = std::move(again[i]);
  data.threads = threads;
  result.exact = std::move(data);
  result.discretisation_mm = discretisation;
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
    if (has_first && !work.over()) {
      find_second(work, result);
      if (result.rounds.size() > 1 && !result.rounds[1].empty()) judge_second(options, work, result);
    }
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

}  // namespace tissued::core
