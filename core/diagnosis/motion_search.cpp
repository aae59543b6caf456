#include "core/diagnosis/motion_search.hpp"

#include <algorithm>
#include <limits>

#include "core/diagnosis/base_models.hpp"
#include "core/diagnosis/discretisation.hpp"
#include "core/diagnosis/seen_motion.hpp"
#include "core/diagnosis/work.hpp"

namespace tissued::core {

namespace {

// Of the shortest period that is seen: the steps of the first look, and how far it goes.
constexpr double kLookStep = 2.0 * kFineStep, kLookFor = 2.7;
constexpr FitControl kLook{4, 5.0}, kExact{6, 1.0};
constexpr std::size_t kMostRounds = 4, kMostFits = 2;
constexpr double kWorthwhile = 0.2;      // of chi square: what an explanation of a swing is to take off
constexpr double kShareOfSearch = 0.6;   // of the budget: what is found is then fitted to all frames
constexpr double kMostAfterwards = 0.3;  // of the budget, for what was held out

// From the best of its starts.
void keep_best_start(Candidate& candidate) {
  const Promise& best = candidate.promises.front();
  Values start = candidate.starts[best.start];
  set_amplitude(*candidate.hypothesis.effects.back(), best.amplitude, start);
  candidate.starts = {start};
}

// What motion shows, and what nothing else shows as well: looked for first. One linear step says little of what makes
// swings fall out of step, and a place that nothing pushes on is ill determined.
bool is_suspect(const Candidate& candidate) {
  const Effect& effect = *candidate.hypothesis.effects.back();
  return effect.is_dynamic() || effect.kind() == "viscoelasticity";
}

// All of a candidate's kinds as they may well be, and numbers as assumed: what a wrong explanation made of the numbers
// may be too far from the right one.
Values afresh(const Candidate& candidate, const std::vector<Candidate>& singles) {
  Values values;
  for (const Candidate& single : singles)
    if (std::find(candidate.kinds.begin(), candidate.kinds.end(), single.kinds.front()) != candidate.kinds.end())
      values.insert(values.end(), single.starts.front().begin(), single.starts.front().end());
  return values;
}

bool promises_more(const Candidate& a, const Candidate& b) {
  if (a.promises.empty() || b.promises.empty()) return !a.promises.empty() && b.promises.empty();
  return a.promises.front().chi_square < b.promises.front().chi_square;
}

bool likelier(const Candidate& a, const Candidate& b) {
  if (a.fast.solved != b.fast.solved) return a.fast.solved;
  return a.fast.solved && a.fast.log_evidence > b.fast.log_evidence;
}

bool is_accepted(const Candidate& base, const std::vector<Candidate>& round) {
  if (round.empty() || !round.front().fast.solved) return false;
  const Fit& more = round.front().fast;
  return more.log_evidence > base.fast.log_evidence + kAccept &&
         more.chi_square < (1.0 - kWorthwhile) * base.fast.chi_square;
}

void fit_first(const FitData& data, std::size_t count, Work& work, std::vector<Candidate>& round, double from,
               double to) {
  work.all(
      count,
      [&](std::size_t i) {
        for (const Values& start : round[i].starts) {
          Fit tried = fit(data, round[i].hypothesis, start, kLook);
          if (tried.solved && (!round[i].fast.solved || tried.log_evidence > round[i].fast.log_evidence))
            round[i].fast = std::move(tried);
        }
      },
      from, to, [&](std::size_t i) { return "fitting " + round[i].name(); });
  std::stable_sort(round.begin(), round.end(), likelier);
}

// One more kind beside those of the base: a suspect if one will do, else what promises most.
std::vector<Candidate> add_one(const FitData& data, const Candidate& base, const std::vector<Candidate>& singles,
                               Work& work, double from, double to) {
  std::vector<Candidate> suspects, others;
  for (const Candidate& single : singles) {
    if (std::find(base.kinds.begin(), base.kinds.end(), single.kinds.front()) != base.kinds.end()) continue;
    (is_suspect(single) ? suspects : others).push_back(extended(base, single));
  }
  for (Candidate& suspect : suspects) {
    suspect.starts.resize(1);
    if (!base.kinds.empty()) suspect.starts.push_back(afresh(suspect, singles));
  }
  const double middle = 0.5 * (from + to);
  fit_first(data, suspects.size(), work, suspects, from, middle);
  const bool is_explained = base.fast.chi_square < base.fast.count;
  if (is_accepted(base, suspects) || is_explained) return suspects;
  work.tell(middle, "what else it may be");
  promise_all(data, base, others);
  std::stable_sort(others.begin(), others.end(), promises_more);
  const auto none = std::find_if(others.begin(), others.end(), [](const Candidate& c) { return c.promises.empty(); });
  std::for_each(others.begin(), none, keep_best_start);
  fit_first(data, std::min(kMostFits, static_cast<std::size_t>(none - others.begin())), work, others, middle, to);
  others.insert(others.end(), suspects.begin(), suspects.end());
  std::stable_sort(others.begin(), others.end(), likelier);
  return others;
}

double frames_of(const std::vector<RecordedTrial>& trials) {
  double frames = 0.0;
  for (const RecordedTrial& trial : trials) frames += trial.frame_count();
  return frames;
}

// What relaxes may do so at two rates: creep takes seconds, what damps a swing relaxes within it.
void relax_further(const FitData& exact, Candidate& found) {
  constexpr double kApart = 6.0, kShare = 0.1;
  if (std::find(found.kinds.begin(), found.kinds.end(), "viscoelasticity") == found.kinds.end()) return;
  Hypothesis further = found.hypothesis;
  std::erase_if(further.fixed, [](const auto& number) {
    return number.first == "viscoelasticity.g2" || number.first == "viscoelasticity.tau2";
  });
  Values start = values_of(found.exact);
  start.emplace_back("viscoelasticity.g2", kShare);
  start.emplace_back("viscoelasticity.tau2", found.exact.value("viscoelasticity.tau1") / kApart);
  Fit fitted = fit(exact, further, start, kExact);
  if (!fitted.solved || fitted.log_evidence < found.exact.log_evidence + kAccept ||
      fitted.chi_square > (1.0 - kWorthwhile) * found.exact.chi_square)
    return;
  found.hypothesis = further;
  found.exact = std::move(fitted);
}

// What lost needs no derivatives.
void shed(std::vector<Candidate>& round) {
  for (Candidate& candidate : round)
    for (TrialResidual& trial : candidate.fast.residuals) trial.derivatives.clear();
}

}  // namespace

SearchResult search_motion(const RecordedSession& session, const SearchOptions& options) {
  Work work(options);
  SearchResult result;
  result.compares_fast = true;
  const ErrorModel errors = error_model(session);
  double period = std::numeric_limits<double>::infinity();
  for (const RecordedTrial& trial : session.trials) period = std::min(period, period_of(trial));
  result.exact = fit_data(session, MotionSteps{kFineStep * period}, errors, &work.stop);
  result.fast = fit_data(session, MotionSteps{kLookStep * period, kLookFor * period}, errors, &work.stop);
  result.exact.threads = result.fast.threads = work.threads();
  result.coarse = result.fast;
  Hypothesis nothing;
  nothing.numbers = false;
  work.tell(0.02, "the elements' own error");
  for (const RecordedTrial& trial : session.trials)
    if (options.refine_mesh)
      result.discretisation_mm =
          std::max(result.discretisation_mm, finer_rest(session.scene, trial.motion->loads).value_or(0.0));
  work.tell(0.03, "the assumed physics");
  // A model without damping swings on, whatever was seen.
  FitData unsettled = fit_data(session, MotionSteps{kFineStep * period, 1e9, false}, errors, &work.stop);
  unsettled.threads = result.exact.threads;
  const double before = work.seconds();
  result.assumed = assess(unsettled, nothing);
  // All three models are then asked for what was held out.
  constexpr double kModels = 3.0;
  work.keep(std::min(kModels * (work.seconds() - before) * frames_of(session.held_out) / frames_of(session.trials),
                     kMostAfterwards * options.budget));
  result.numbers = numbers_candidate();
  result.numbers.hypothesis.releases = static_cast<int>(session.trials.size());
  work.tell(0.1, "the assumed physics' own numbers");
  result.numbers.fast = fit(result.fast, result.numbers.hypothesis, {}, kLook);
  const std::vector<Candidate> singles = motion_candidates(session);
  Candidate chosen = result.numbers;
  for (std::size_t r = 0; r < kMostRounds && result.numbers.fast.solved; ++r) {
    if (work.over() || work.seconds() > kShareOfSearch * options.budget) {
      result.remarks.emplace_back("No further effect was looked for: the time left was for fitting those found.");
      break;
    }
    const double from = 0.15 + 0.12 * static_cast<double>(r);
    result.rounds.push_back(add_one(result.fast, chosen, singles, work, from, from + 0.12));
    shed(result.rounds.back());
    if (!is_accepted(chosen, result.rounds.back())) {
      result.rounds.pop_back();
      break;
    }
    chosen = result.rounds.back().front();
  }
  work.tell(0.65, "fitting " + chosen.name() + " to all frames");
  if (!chosen.kinds.empty()) {
    Candidate& found = result.rounds[chosen.kinds.size() - 1].front();
    found.exact = fit(result.exact, found.hypothesis, values_of(found.fast), kExact);
    work.tell(0.8, "relaxation at two rates");
    if (found.exact.solved && !work.over()) relax_further(result.exact, found);
  }
  work.tell(0.9, "the assumed physics' own numbers");
  result.numbers.exact =
      fit(result.exact, result.numbers.hypothesis, values_of(result.numbers.fast), FitControl{1, 1.0});
  result.complete = !work.stop;
  for (FitData* data : {&result.coarse, &result.fast, &result.exact}) data->stop = nullptr;
  if (!result.numbers.best().solved) {
    result.numbers.hypothesis = nothing;
    result.numbers.exact = result.assumed;
  }
  return result;
}

}  // namespace tissued::core
