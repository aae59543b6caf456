#include "core/diagnosis/search.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/discretisation.hpp"
#include "core/diagnosis/motion_search.hpp"
#include "core/diagnosis/placement.hpp"

namespace tissued::core {

namespace {

constexpr double kTravel = 3.0, kCoarseTravel = 5.0;  // mm between keys
constexpr FitControl kFirstLook{4, 10.0}, kFast{16, 3.0}, kExact{6, 0.5};
constexpr std::size_t kMostFast = 6, kMostExact = 4, kMostPairs = 2, kStartsToFit = 3;
constexpr double kNear = 0.3;        // of the largest advantage: candidates with less are not looked at more closely
constexpr double kPromising = 0.1;   // likewise, after the first look
constexpr double kWorthExact = 8.0;  // advantage below which a candidate is not looked at more closely

// A first look at a candidate: a few steps on few keys, from the most promising of its starts.
void look_at(const FitData& coarse, Candidate& candidate) {
  std::vector<Values> starts = candidate.starts;
  if (starts.size() > 1) {
    candidate.promises = most_promising(coarse, candidate.hypothesis, starts);
    starts.clear();
    for (const Promise& promise : candidate.promises) {
      if (starts.size() == kStartsToFit) break;
      starts.push_back(candidate.starts[promise.start]);
      const Effect& effect = *candidate.hypothesis.effects.back();
      if (effect.amplitude() < 0) continue;
      const std::string name = model_parameter(effect, effect.parameters()[effect.amplitude()]);
      for (auto& [of, value] : starts.back())
        if (of == name) value = promise.amplitude;
    }
  }
  for (const Values& start : starts) {
    Fit tried = fit(coarse, candidate.hypothesis, start, kFirstLook);
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
      : coarse_(&coarse), fast_(&fast), exact_(&exact), work_(&work) {
    const Values values = values_of(base.best());
    const FitControl control{3, 3.0};
    on_coarse_ = fit(coarse, base.hypothesis, values, control).log_evidence;
    on_fast_ = fit(fast, base.hypothesis, values, control).log_evidence;
  }

  void run(std::vector<Candidate>& candidates, std::size_t most_exact, double from, double to) {
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
    const std::vector<Candidate*> chosen = best_of(candidates, most_exact, kNear);
    work_->all(
        chosen.size(),
        [&](std::size_t i) {
          chosen[i]->exact = fit(*exact_, chosen[i]->hypothesis, values_of(chosen[i]->fast), kExact);
          shed(chosen[i]->exact);
        },
        second, to, [&](std::size_t i) { return "looking closely at " + chosen[i]->name(); });
    std::stable_sort(candidates.begin(), candidates.end(), better);
  }

 private:
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
  Work* work_;
  double on_coarse_ = 0.0, on_fast_ = 0.0;
};

// Other numbers alone bring the markers about down to noise: then it is as well to judge elements where these are.
bool nearly_explains(const SearchResult& result) {
  constexpr double kNearly = 2.0;
  const Fit& numbers = result.numbers.exact;
  if (!numbers.solved || !result.numbers.fast.solved) return false;
  const Channels channels = channels_of(result.exact.session->scene);
  return structure_left(result.exact.errors, channels, pointers_to(numbers.residuals))[0] < kNearly;
}

// What elements err depends on Poisson's ratio more than on anything else.
void correct_at_numbers(const RecordedSession& session, Work& work, SearchResult& result) {
  constexpr double kAsGood = 0.005;
  const Fit numbers = result.numbers.exact;
  if (std::abs(numbers.value("poissons_ratio") - session.scene.material.poissons_ratio) < kAsGood ||
      session.scene.mesh.tet_count() > kMostRefinedTets)
    return;
  Scene fitted = session.scene;
  fitted.material.youngs_modulus = numbers.value("youngs_modulus");
  fitted.material.poissons_ratio = numbers.value("poissons_ratio");
  result.discretisation_mm = correct_by_finer(session, fitted, work, result.exact);
  Fit again = fit(result.exact, result.numbers.hypothesis, values_of(numbers), kExact);
  if (again.solved) result.numbers.exact = std::move(again);
}

// Candidates are compared by linear elements first: those are to answer as quadratic ones do where numbers are.
void rebase_on_numbers(Work& work, SearchResult& result) {
  work.all(
      2, [&](std::size_t job) { rebase(result.exact, result.numbers.exact, job == 0 ? result.fast : result.coarse); },
      0.25, 0.3, [](std::size_t) { return "the assumed physics"; });
  Fit again = fit(result.fast, result.numbers.hypothesis, values_of(result.numbers.exact), kFast);
  if (again.solved) result.numbers.fast = std::move(again);
}

// The assumed physics by all models, and its numbers refitted.
void assess_assumed(const RecordedSession& session, const SearchOptions& options, Work& work, SearchResult& result) {
  const ErrorModel errors = error_model(session);
  result.exact = fit_data(session, kTravel, FemElement::p2, errors, &work.stop);
  result.fast = fit_data(session, kTravel, FemElement::p1, errors, &work.stop);
  result.coarse = fit_data(session, kCoarseTravel, FemElement::p1, errors, &work.stop);
  work.tell(0.02, "the assumed physics");
  if (options.refine_mesh && session.scene.mesh.tet_count() <= kMostRefinedTets)
    result.discretisation_mm = correct_by_finer(session, session.scene, work, result.exact);
  work.all(
      2,
      [&](std::size_t job) {
        FitData& data = job == 0 ? result.exact : result.coarse;
        data.placement = placement_slopes(session.scene, data.paths);
      },
      0.2, 0.21, [](std::size_t) { return "where markers sit"; });
  result.fast.placement = result.exact.placement;
  Hypothesis nothing;
  nothing.numbers = false;
  work.all(
      3,
      [&](std::size_t job) {
        if (job == 0) result.assumed = assess(result.exact, nothing);
        if (job == 1) correct_by_quadratic(result.fast);
        if (job == 2) correct_by_quadratic(result.coarse);
      },
      0.21, 0.25, [](std::size_t) { return "the assumed physics"; });
  shed(result.assumed);
  result.numbers = numbers_candidate();
  result.numbers.fast = fit(result.fast, result.numbers.hypothesis, {}, kFast);
  result.numbers.exact = fit(result.exact, result.numbers.hypothesis, values_of(result.numbers.fast), kExact);
  if (options.refine_mesh && nearly_explains(result)) correct_at_numbers(session, work, result);
  if (nearly_explains(result)) rebase_on_numbers(work, result);
  if (result.numbers.best().solved) return;
  // Interrupted before any number was known: what is said is said of the assumed physics.
  if (!result.assumed.solved) {
    FitData unhurried = result.exact;
    unhurried.stop = nullptr;
    result.assumed = assess(unhurried, nothing);
    shed(result.assumed);
  }
  result.numbers.hypothesis = nothing;
  result.numbers.exact = result.assumed;
}

void find_second(Work& work, SearchResult& result) {
  const Candidate first = result.rounds[0].front();
  FitData coarse = result.coarse, fast = result.fast;
  work.all(
      2, [&](std::size_t job) { rebase(result.exact, first.exact, job == 0 ? fast : coarse); }, 0.6, 0.62,
      [](std::size_t) { return "a second explanation"; });
  std::vector<Candidate> pairs;
  for (std::size_t i = 1; i < result.rounds[0].size(); ++i)
    if (result.rounds[0][i].fast.solved) pairs.push_back(extended(first, result.rounds[0][i]));
  Narrowing(coarse, fast, result.exact, first, work).run(pairs, kMostPairs, 0.62, 1.0);
  result.rounds.push_back(std::move(pairs));
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
    Narrowing(result.coarse, result.fast, result.exact, result.numbers, work).run(singles, kMostExact, 0.3, 0.6);
    const bool has_first =
        !singles.empty() && singles.front().exact.solved && advantage(result, singles.front()) >= kAccept;
    result.rounds.push_back(std::move(singles));
    if (has_first && !work.over()) find_second(work, result);
  }
  result.complete = !work.stop;
  for (FitData* data : {&result.coarse, &result.fast, &result.exact}) data->stop = nullptr;  // it was this search's
  return result;
}

double advantage(const SearchResult& result, const Candidate& candidate) {
  const bool exact = !result.compares_fast && candidate.exact.solved && result.numbers.exact.solved;
  const Fit& base = exact ? result.numbers.exact : result.numbers.fast;
  const Fit& fit = exact ? candidate.exact : candidate.fast;
  if (!fit.solved || !base.solved) return -1e9;
  return fit.log_evidence - base.log_evidence;
}

}  // namespace tissued::core
