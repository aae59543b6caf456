#include "core/diagnosis/narrowing.hpp"

#include <algorithm>
#include <string>

namespace tissued::core {

namespace {

constexpr FitControl kFirstLook{8, 10.0};
constexpr std::size_t kMostFast = 6;
constexpr double kPromised = 10.0;                 // of chi square: with less in one linear step, one look is enough
constexpr double kPromisedBeside = kAcceptBeside;  // likewise beside another effect, half of what it takes
constexpr double kNear = 0.3;        // of what the most promising start promises: those with less are not begun from
constexpr double kNearBest = 0.5;    // of the largest advantage: candidates with less are not looked at more closely
constexpr double kPromising = 0.1;   // likewise, after the first look
constexpr double kWorthExact = 8.0;  // advantage below which a candidate is not looked at more closely

// A first look at a candidate: some steps on few keys, from the most promising of its starts.
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

bool better(const Candidate& a, const Candidate& b) {
  if (a.exact.solved != b.exact.solved) return a.exact.solved;
  return a.best().log_evidence > b.best().log_evidence;
}

}  // namespace

void shed(Fit& fit) {
  for (TrialResidual& trial : fit.residuals) trial.derivatives.clear();
}

Narrowing::Narrowing(const FitData& coarse, const FitData& fast, const FitData& exact, const Candidate& base,
                     Work& work)
    : coarse_(&coarse), fast_(&fast), exact_(&exact), base_(&base), work_(&work) {
  const Values values = values_of(base.best());
  const FitControl control{3, 3.0};
  const Fit on_coarse = fit(coarse, base.hypothesis, values, control),
            on_fast = fit(fast, base.hypothesis, values, control);
  has_base_ = on_coarse.solved && on_fast.solved;
  on_coarse_ = on_coarse.log_evidence;
  on_fast_ = on_fast.log_evidence;
}

bool Narrowing::run(std::vector<Candidate>& candidates, std::size_t most_exact, double from, double to) {
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
  std::vector<Candidate*> chosen = best_of(candidates, most_exact, kNearBest);
  // Linear elements err more beside an effect than where nothing is missing.
  if (!base_->kinds.empty()) keep_promising(chosen, second, 0.5 * (second + to));
  // Beside an effect fits take long: the likeliest has all threads, and is done before time is over if any is.
  const bool in_turn = chosen.size() == 1 || !base_->kinds.empty();
  FitData data = *exact_;
  if (in_turn) data.threads = work_->threads();
  const std::size_t turns = in_turn ? chosen.size() : 1;
  const double each = (to - second) / static_cast<double>(turns);
  for (std::size_t turn = 0; turn < turns; ++turn) {
    const double begin = second + each * static_cast<double>(turn);
    work_->all(
        in_turn ? 1 : chosen.size(),
        [&](std::size_t i) {
          chosen[turn + i]->exact = fit(data, chosen[turn + i]->hypothesis, values_of(chosen[turn + i]->fast), kExact);
          shed(chosen[turn + i]->exact);
        },
        begin, begin + each, [&](std::size_t i) { return "looking closely at " + chosen[turn + i]->name(); });
  }
  std::stable_sort(candidates.begin(), candidates.end(), better);
  return true;
}

void Narrowing::keep_promising(std::vector<Candidate*>& chosen, double from, double to) {
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

std::vector<Candidate*> Narrowing::best_of(std::vector<Candidate>& candidates, std::size_t most, double share) const {
  std::vector<Candidate*> order;
  for (Candidate& candidate : candidates)
    if (candidate.fast.solved && candidate.fast.log_evidence > on_fast_ + kWorthExact) order.push_back(&candidate);
  std::stable_sort(order.begin(), order.end(),
                   [](const Candidate* a, const Candidate* b) { return a->fast.log_evidence > b->fast.log_evidence; });
  while (!order.empty() && (order.size() > most || order.back()->fast.log_evidence - on_fast_ <
                                                       share * (order.front()->fast.log_evidence - on_fast_)))
    order.pop_back();
  return order;
}

void say_untried(const char* what, const Work& work, SearchResult& result) {
  if (work.stop) return;  // which is said anyway
  result.complete = false;
  result.remarks.push_back(std::string("Linear elements find no equilibrium where ") + what +
                           " was to be looked for: it was not.");
}

}  // namespace tissued::core
