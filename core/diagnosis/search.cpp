#include "core/diagnosis/search.hpp"

#include <omp.h>

#include <algorithm>
#include <mutex>

#include "core/diagnosis/discretisation.hpp"
#include "core/diagnosis/placement.hpp"

namespace tissued::core {

namespace {

constexpr double kTravel = 3.0, kCoarseTravel = 5.0;  // mm between keys
constexpr double kOffset = 0.5;                       // mm, to which markers are placed
constexpr double kMarkerShare = 0.0045;               // of the load: what quadratic elements may err at a marker
constexpr double kForceShare = 0.03;                  // of the peak force, likewise
constexpr double kForceShape = 0.004;                 // of the peak force: what is noise to all that follows
// Of the load and of the peak force: what quadratic elements may err beside what goes with the load, half way there.
constexpr double kMarkerBend = 0.0015, kForceBend = 0.01;
// Of what finer elements say otherwise: what a body is that is not made of elements, and recordings of one that is.
constexpr double kCorrectionMean = 0.35, kCorrectionSd = 0.35;
constexpr FitControl kFirstLook{4, 10.0}, kFast{16, 3.0}, kExact{6, 0.5};
constexpr std::size_t kMostFast = 6, kMostExact = 4, kMostPairs = 2, kStartsToFit = 3;
constexpr double kNear = 0.3;        // of the largest advantage: candidates with less are not looked at more closely
constexpr double kPromising = 0.1;   // likewise, after the first look
constexpr double kWorthExact = 8.0;  // advantage below which a candidate is not looked at more closely

class Work {
 public:
  Work(const SearchOptions& options) : options_(&options), begin_(std::chrono::steady_clock::now()) {}

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
  bool over() {
    if (seconds() > options_->budget || (options_->interrupted != nullptr && options_->interrupted->load()))
      stop = true;
    return stop;
  }
  void tell(double share, const std::string& what) {
    if (!options_->progress) return;
    const std::lock_guard lock(mutex_);
    share_ = std::max(share_, share);
    options_->progress(share_, what);
  }
  // Independent jobs over the threads; none is begun when time is over.
  void all(std::size_t count, const std::function<void(std::size_t)>& job, double from, double to,
           const std::function<std::string(std::size_t)>& what) {
    const int threads = options_->threads > 0 ? options_->threads : omp_get_num_procs();
    std::size_t done = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (std::size_t i = 0; i < count; ++i) {
      if (over()) continue;
      job(i);
      std::size_t now = 0;
#pragma omp atomic capture
      now = ++done;
      tell(from + (to - from) * static_cast<double>(now) / static_cast<double>(count), what(i));
    }
  }
  std::atomic<bool> stop{false};

 private:
  const SearchOptions* options_;
  std::chrono::steady_clock::time_point begin_;
  std::mutex mutex_;
  double share_ = 0.0;
};

std::size_t key_at_peak(const LoadPath& path) {
  std::size_t peak = 0;
  for (std::size_t k = 1; k < path.keys().size(); ++k)
    if (path.keys()[k].load > path.keys()[peak].load + 1e-9) peak = k;
  return peak;
}

// N, the largest force of a pad in a trial; 0 where none was seen.
double peak_force(const RecordedTrial& trial, const Channels& channels, int pad) {
  double peak = 0.0;
  for (Eigen::Index f = 0; f < trial.seen.rows(); ++f) {
    const double force = trial.seen.row(f).segment<3>(channels.of_force(pad)).norm();
    if (std::isfinite(force)) peak = std::max(peak, force);
  }
  return peak;
}

// Pooled over the channels of a kind: a median of medians.
void pool_noise(const Channels& channels, Eigen::VectorXd& noise) {
  const auto pool = [&noise](int begin, int count) {
    if (count == 0) return;
    std::vector<double> all(noise.data() + begin, noise.data() + begin + count);
    std::nth_element(all.begin(), all.begin() + count / 2, all.end());
    noise.segment(begin, count).setConstant(all[static_cast<std::size_t>(count / 2)]);
  };
  pool(0, 3 * channels.markers);
  pool(3 * channels.markers, 3 * channels.targets);
  pool(3 * (channels.markers + channels.targets), 3 * channels.pads);
}

ErrorModel error_model(const RecordedSession& session) {
  const Channels channels = channels_of(session.scene);
  Eigen::VectorXd stated(channels.count());
  for (int c = 0; c < channels.count(); ++c) stated[c] = session.noise_of(c);
  ErrorModel errors;
  errors.noise = noise_seen(session.trials, stated);
  pool_noise(channels, errors.noise);
  errors.offset.setZero(channels.count());
  errors.offset.head(3 * channels.markers).setConstant(kOffset);
  errors.discretisation.setZero(static_cast<Eigen::Index>(session.trials.size()), channels.count());
  errors.bend = errors.discretisation;
  double largest = 0.0;
  for (std::size_t k = 0; k < session.trials.size(); ++k)
    for (int pad = 0; pad < channels.pads; ++pad) {
      const double peak = peak_force(session.trials[k], channels, pad);
      largest = std::max(largest, peak);
      const auto row = static_cast<Eigen::Index>(k);
      errors.discretisation.row(row).segment<3>(channels.of_force(pad)).setConstant(kForceShare * peak);
      errors.bend.row(row).segment<3>(channels.of_force(pad)).setConstant(kForceBend * peak);
    }
  errors.noise.tail(3 * channels.pads).array() =
      (errors.noise.tail(3 * channels.pads).array().square() + std::pow(kForceShape * largest, 2)).sqrt();
  return errors;
}

FitData fit_data(const RecordedSession& session, double travel, FemElement element, const ErrorModel& errors,
                 const std::atomic<bool>* stop) {
  FitData data;
  data.session = &session;
  data.errors = errors;
  data.element = element;
  data.stop = stop;
  const Channels channels = channels_of(session.scene);
  for (std::size_t k = 0; k < session.trials.size(); ++k) {
    data.paths.emplace_back(session.trials[k], session.scene, travel);
    const auto keys = static_cast<Eigen::Index>(data.paths.back().keys().size());
    data.correction.push_back(RowMatrix::Zero(keys, channels.count()));
    data.force_factor.push_back(RowMatrix::Ones(keys, channels.pads));
    const auto row = static_cast<Eigen::Index>(k);
    const int seen = 3 * (channels.markers + channels.targets);
    data.errors.discretisation.row(row).head(seen).setConstant(kMarkerShare * data.paths.back().peak_load());
    data.errors.bend.row(row).head(seen).setConstant(kMarkerBend * data.paths.back().peak_load());
  }
  return data;
}

// What finer elements answer at the peak of each trial, into `exact`, in proportion to the load; scene: the session's,
// but for its numbers.
double correct_by_finer(const RecordedSession& session, const Scene& scene, Work& work, FitData& exact) {
  const Channels channels = channels_of(session.scene);
  const int seen = 3 * (channels.markers + channels.targets);
  std::vector<Eigen::RowVectorXd> differences(exact.paths.size()), factors(exact.paths.size());
  const auto solve = [&](std::size_t k) {
    PathSolver solver(scene, {});
    PathAnswer answer;
    const LoadPath& path = exact.paths[k];
    if (!solver.solve(path, 0, {}, answer)) return;
    const std::size_t peak = key_at_peak(path);
    const FinerAnswer finer = finer_answer(scene, path.keys()[peak].pads, solver.positions(0)[peak]);
    if (!finer.solved) return;
    const Eigen::RowVectorXd coarse = answer.values.row(static_cast<Eigen::Index>(peak));
    differences[k] = finer.values - coarse;
    factors[k] = Eigen::RowVectorXd::Ones(channels.pads);
    for (int pad = 0; pad < channels.pads; ++pad) {
      const double force = coarse.segment<3>(channels.of_force(pad)).norm();
      if (force > 1e-3) factors[k][pad] = finer.values.segment<3>(channels.of_force(pad)).norm() / force;
    }
  };
  work.all(exact.paths.size(), solve, 0.05, 0.2,
           [&](std::size_t k) { return "the elements' own error in " + session.trials[k].name; });
  double square = 0.0, count = 0.0;
  for (std::size_t k = 0; k < exact.paths.size(); ++k) {
    if (differences[k].size() == 0) continue;
    const LoadPath& path = exact.paths[k];
    for (std::size_t i = 0; i < path.keys().size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      exact.correction[k].row(row).head(seen) =
          kCorrectionMean * path.keys()[i].load / path.peak_load() * differences[k].head(seen);
      exact.force_factor[k].row(row) = factors[k].array().pow(kCorrectionMean);
    }
    square += std::pow(kCorrectionMean, 2) * differences[k].head(3 * channels.markers).squaredNorm();
    count += 3.0 * channels.markers;
  }
  exact.correction_sd = kCorrectionSd / kCorrectionMean;
  return count > 0.0 ? std::sqrt(square / count) : 0.0;
}

double force_ratio(const Eigen::RowVector3d& linear, const Eigen::RowVector3d& wanted) {
  constexpr double kUnloaded = 0.02, kUsual = 0.75;  // N; of linear elements' excess
  return linear.norm() > kUnloaded ? wanted.norm() / linear.norm() : kUsual;
}

// Makes the answers of linear elements those of quadratic ones where nothing is left out.
void correct_by_quadratic(FitData& fast) {
  const RecordedSession& session = *fast.session;
  const Channels channels = channels_of(session.scene);
  PathSolver linear(session.scene, {}, FemElement::p1), quadratic(session.scene, {});
  for (std::size_t k = 0; k < fast.paths.size(); ++k) {
    PathAnswer by_linear, by_quadratic;
    if (!linear.solve(fast.paths[k], 0, {}, by_linear) || !quadratic.solve(fast.paths[k], 0, {}, by_quadratic))
      continue;
    for (Eigen::Index i = 0; i < by_linear.values.rows(); ++i) {
      fast.correction[k].row(i) = by_quadratic.values.row(i) - by_linear.values.row(i);
      fast.correction[k].row(i).tail(3 * channels.pads).setZero();
      for (int pad = 0; pad < channels.pads; ++pad) {
        fast.force_factor[k](i, pad) = force_ratio(by_linear.values.row(i).segment<3>(channels.of_force(pad)),
                                                   by_quadratic.values.row(i).segment<3>(channels.of_force(pad)));
      }
    }
  }
  fast.correction_sd = 0.05;
}

// Makes the answers of linear elements those of quadratic ones at a fit by these, wherever that lies.
void rebase(const FitData& exact, const Fit& at, FitData& fast) {
  const RecordedSession& session = *fast.session;
  const Channels channels = channels_of(session.scene);
  PathSolver linear(session.scene, at.hypothesis.effects, FemElement::p1);
  for (const auto& [name, value] : at.hypothesis.fixed) linear.set_parameter(name, value);
  for (const Unknown& unknown : at.unknowns)
    if (unknown.source == Unknown::Source::body) linear.set_parameter(unknown.name, unknown.value);
  const double share = at.unknowns.back().value;
  for (std::size_t k = 0; k < fast.paths.size(); ++k) {
    PathAnswer by_linear;
    if (!linear.solve(fast.paths[k], 0, {}, by_linear)) continue;
    for (Eigen::Index i = 0; i < by_linear.values.rows(); ++i) {
      const PathPlace place = exact.paths[k].place(fast.paths[k].keys()[static_cast<std::size_t>(i)].time);
      Eigen::RowVectorXd wanted = Eigen::RowVectorXd::Zero(channels.count());
      for (std::size_t p = 0; p < place.keys.size(); ++p) {
        Eigen::RowVectorXd answer =
            at.answers[k].values.row(place.keys[p]) + share * exact.correction[k].row(place.keys[p]);
        for (int pad = 0; pad < channels.pads; ++pad)
          answer.segment<3>(channels.of_force(pad)) *= std::pow(exact.force_factor[k](place.keys[p], pad), share);
        wanted += place.weights[p] * answer;
      }
      fast.correction[k].row(i) = wanted - by_linear.values.row(i);
      fast.correction[k].row(i).tail(3 * channels.pads).setZero();
      for (int pad = 0; pad < channels.pads; ++pad)
        fast.force_factor[k](i, pad) = force_ratio(by_linear.values.row(i).segment<3>(channels.of_force(pad)),
                                                   wanted.segment<3>(channels.of_force(pad)));
    }
  }
}

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
  result.exact.placement = placement_slopes(session.scene, result.exact.paths);
  result.fast.placement = result.exact.placement;
  if (!work.over()) result.coarse.placement = placement_slopes(session.scene, result.coarse.paths);
  Hypothesis nothing;
  nothing.numbers = false;
  work.all(
      3,
      [&](std::size_t job) {
        if (job == 0) result.assumed = assess(result.exact, nothing);
        if (job == 1) correct_by_quadratic(result.fast);
        if (job == 2) correct_by_quadratic(result.coarse);
      },
      0.2, 0.25, [](std::size_t) { return "the assumed physics"; });
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
  const Candidate first = result.singles.front();
  FitData coarse = result.coarse, fast = result.fast;
  work.all(
      2, [&](std::size_t job) { rebase(result.exact, first.exact, job == 0 ? fast : coarse); }, 0.6, 0.62,
      [](std::size_t) { return "a second explanation"; });
  for (std::size_t i = 1; i < result.singles.size(); ++i)
    if (result.singles[i].fast.solved) result.pairs.push_back(pair_candidate(first, result.singles[i]));
  Narrowing(coarse, fast, result.exact, first, work).run(result.pairs, kMostPairs, 0.62, 1.0);
}

}  // namespace

SearchResult search(const RecordedSession& session, const SearchOptions& options) {
  Work work(options);
  SearchResult result;
  assess_assumed(session, options, work, result);
  if (result.numbers.fast.solved) {
    result.singles = single_candidates(session, result.fast, result.numbers.fast);
    // The long ones first: the threads end together.
    std::stable_sort(result.singles.begin(), result.singles.end(), [](const Candidate& a, const Candidate& b) {
      const auto weight = [](const Candidate& c) {
        const bool has_history = !c.hypothesis.effects.empty() && c.hypothesis.effects.front()->has_history();
        return c.starts.size() * (has_history ? 10 : 1);
      };
      return weight(a) > weight(b);
    });
    Narrowing(result.coarse, result.fast, result.exact, result.numbers, work).run(result.singles, kMostExact, 0.3, 0.6);
    const bool has_first = !result.singles.empty() && result.singles.front().exact.solved &&
                           advantage(result, result.singles.front()) >= kAccept;
    if (has_first && !work.over()) find_second(work, result);
  }
  result.complete = !work.stop;
  return result;
}

double advantage(const SearchResult& result, const Candidate& candidate) {
  const bool exact = candidate.exact.solved && result.numbers.exact.solved;
  const Fit& base = exact ? result.numbers.exact : result.numbers.fast;
  const Fit& fit = exact ? candidate.exact : candidate.fast;
  if (!fit.solved || !base.solved) return -1e9;
  return fit.log_evidence - base.log_evidence;
}

}  // namespace tissued::core
