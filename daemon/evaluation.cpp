#include "daemon/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "daemon/ctl_options.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/job_pool.hpp"
#include "daemon/scene_loader.hpp"

namespace tissued::daemon {
namespace {

constexpr int kJumpIterations = 600;  // that a jump is followed for; the first paper's curves are flat by 500
constexpr std::size_t kMostJumpTrials = 4;

std::vector<std::string> marker_sets_of(const config::Bundle& bundle, const std::vector<std::string>& wanted) {
  std::vector<std::string> known;
  for (const config::MarkerSet& set : bundle.marker_sets) known.push_back(set.name);
  if (wanted.empty()) return known.empty() ? std::vector<std::string>{kAllMarkers} : known;
  known.insert(known.begin(), kAllMarkers);
  for (const std::string& name : wanted) {
    if (std::ranges::count(known, name) == 0) {
      throw UsageError("--marker-sets: bundle " + bundle.scene.name + " has no marker set `" + name + "`; it has " +
                       join_or(known));
    }
  }
  return wanted;
}

Setup make_setup(const std::string& folder, const EvaluationRequest& request, const EvaluatedModel& model,
                 const std::string& marker_set) {
  Setup setup{model, marker_set, {}, {}};
  std::vector<std::string> overrides = request.overrides;
  overrides.insert(overrides.end(), model.overrides.begin(), model.overrides.end());
  overrides.push_back("markers=" + marker_set);
  overrides.emplace_back("simulator.threads=1");
  setup.config = config::config_for_bundle(folder, overrides);
  apply_model(setup.config);
  setup.scene = load_scene(setup.config.bundle);
  return setup;
}

// In open loop one setup stands for all marker sets.
std::vector<Setup> make_setups(const std::string& folder, const config::Bundle& bundle,
                               const EvaluationRequest& request) {
  const std::vector<std::string> sets = marker_sets_of(bundle, request.marker_sets);
  std::vector<Setup> setups;
  for (const EvaluatedModel& model : request.models) {
    for (const std::string& set : sets) {
      setups.push_back(make_setup(folder, request, model, set));
      setups.back().config.simulator.alarm.enabled = false;  // nothing here reads it, and it takes long to build
      if (core::reads_markers(setups.back().config.simulator)) continue;
      setups.back().marker_set = kNoMarkers;
      break;
    }
  }
  return setups;
}

void load_recordings(BundleEvaluation& evaluation, const std::vector<std::string>& wanted) {
  const config::Bundle& bundle = evaluation.bundle;
  for (const config::TrialInfo& trial : bundle.trials) {
    if (!wanted.empty() && std::ranges::count(wanted, trial.name) == 0) continue;
    evaluation.recordings.emplace_back(bundle, trial, read_trial(trial.file));
  }
  if (!evaluation.recordings.empty()) return;
  throw UsageError(bundle.trials.empty() ? "bundle " + bundle.scene.name + " has no trials"
                                         : "--trials: bundle " + bundle.scene.name + " has none of them");
}

double largest_push(const Recording& recording) {
  double most = 0.0;
  for (const PadPush& push : recording.pushes()) most = std::max(most, push.largest_mm);
  return most;
}

std::vector<std::size_t> choose_jump_trials(const std::vector<Recording>& recordings) {
  const auto pads_of = [](const Recording& recording) {
    std::set<std::size_t> pads;
    for (const PadPush& push : recording.pushes()) pads.insert(push.pad);
    return pads;
  };
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (recordings[i].hold().empty()) continue;
    const auto same_pads = std::ranges::find_if(
        chosen, [&](std::size_t other) { return pads_of(recordings[other]) == pads_of(recordings[i]); });
    if (same_pads == chosen.end()) {
      chosen.push_back(i);
    } else if (largest_push(recordings[i]) > largest_push(recordings[*same_pads])) {
      *same_pads = i;
    }
  }
  chosen.resize(std::min(chosen.size(), kMostJumpTrials));
  return chosen;
}

void run_jump(const Setup& setup, const Recording& recording, bool pad_forces, EvaluatedRun& run) {
  const int iterations = setup.config.simulator.solver.iterations;
  const auto frames = static_cast<std::size_t>((kJumpIterations + iterations - 1) / iterations);
  run.jump_begin = recording.opening_rest();
  run.jump = run_trial(setup.config, setup.scene, recording, jump_order(recording, frames), pad_forces);
}

void require_known_trials(const std::vector<std::unique_ptr<BundleEvaluation>>& bundles,
                          const std::vector<std::string>& wanted) {
  for (const std::string& name : wanted) {
    const auto has = [&](const auto& evaluation) { return evaluation->bundle.find_trial(name) != nullptr; };
    if (std::ranges::any_of(bundles, has)) continue;
    std::vector<std::string> known;
    for (const auto& evaluation : bundles) {
      for (const config::TrialInfo& trial : evaluation->bundle.trials) known.push_back(trial.name);
    }
    throw UsageError("--trials: there is no trial `" + name + "`; there are " +
                     (known.empty() ? "none" : join_or(known)));
  }
}

}  // namespace

bool BundleEvaluation::has_measured_target() const {
  return std::ranges::any_of(runs, [](const auto& of_setup) {
    return std::ranges::any_of(of_setup, [](const EvaluatedRun& run) {
      return std::ranges::any_of(run.score.targets, [](const TargetScore& target) { return target.frames > 0; });
    });
  });
}

Evaluation::Evaluation(const EvaluationRequest& request) : pad_forces_(request.pad_forces), session_(request.session) {
  for (const std::string& folder : request.bundles) {
    bundles_.push_back(std::make_unique<BundleEvaluation>());
    bundles_.back()->bundle = config::load_bundle(folder);
  }
  require_known_trials(bundles_, request.trials);
  for (std::size_t b = 0; b < bundles_.size(); ++b) {
    BundleEvaluation& evaluation = *bundles_[b];
    evaluation.setups = make_setups(request.bundles[b], evaluation.bundle, request);
    load_recordings(evaluation, request.trials);
    evaluation.jump_trials = choose_jump_trials(evaluation.recordings);
    evaluation.runs.assign(evaluation.setups.size(), std::vector<EvaluatedRun>(evaluation.recordings.size()));
    const std::size_t in_turn = session_ ? evaluation.recordings.size() : 1;
    for (std::size_t recording = 0; recording < evaluation.recordings.size(); recording += in_turn) {
      for (std::size_t setup = 0; setup < evaluation.setups.size(); ++setup) {
        jobs_.push_back({&evaluation, setup, recording, in_turn});
      }
    }
  }
}

void Evaluation::run(int threads, const std::function<void(std::size_t)>& on_done) {
  run_jobs(
      jobs_.size(), threads, [this](std::size_t i) { run_job(jobs_[i]); }, on_done);
}

void Evaluation::run_job(const Job& job) {
  BundleEvaluation& evaluation = *job.bundle;
  const Setup& setup = evaluation.setups[job.setup];
  TrialRunner runner(setup.config, setup.scene, pad_forces_);
  for (std::size_t i = job.recording; i < job.recording + job.count; ++i) {
    const Recording& recording = evaluation.recordings[i];
    EvaluatedRun& run = evaluation.runs[job.setup][i];
    run.recorded = runner.run(recording, recorded_order(recording));
    run.score = score_run(evaluation.bundle, recording, run.recorded);
    if (std::ranges::count(evaluation.jump_trials, i) > 0) run_jump(setup, recording, pad_forces_, run);
  }
}

}  // namespace tissued::daemon
