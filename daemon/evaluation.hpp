#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/daemon_config.hpp"
#include "daemon/evaluated_model.hpp"
#include "daemon/run_score.hpp"
#include "daemon/trial_run.hpp"

namespace tissued::daemon {

struct EvaluationRequest {
  std::vector<std::string> bundles;      ///< folders
  std::vector<EvaluatedModel> models;    ///< in the order in which they are shown
  std::vector<std::string> marker_sets;  ///< empty: every set of a bundle, or all markers where it names no sets
  std::vector<std::string> trials;       ///< empty: all of a bundle, held-out ones included
  std::vector<std::string> overrides;    ///< of the configuration, for all models; a model's own come after them
  bool pad_forces = false;               ///< recorded ones are fed, too
  bool session = false;                  ///< a bundle's trials in turn by one simulator, not each from rest
};

/// The name of the set of all markers, and what stands for a set where a model reads no markers.
inline constexpr const char* kAllMarkers = "all";
inline constexpr const char* kNoMarkers = "-";

/// A model with a marker set, on one bundle.
struct Setup {
  EvaluatedModel model;
  std::string marker_set;  ///< kNoMarkers in open loop
  config::DaemonConfig config;
  core::Scene scene;  ///< config's, with its mesh

  bool closed_loop() const { return marker_set != kNoMarkers; }
};

/// One trial by one setup.
struct EvaluatedRun {
  TrialRun recorded;           ///< frames as they were recorded
  TrialRun jump;               ///< pads put into the hold at once; empty but for BundleEvaluation::jump_trials
  std::size_t jump_begin = 0;  ///< first frame of `jump` after the opening rest
  RunScore score;              ///< of `recorded`
};

/// All runs on one bundle. Recordings refer to the bundle: stays where it is.
struct BundleEvaluation {
  config::Bundle bundle;  ///< with all markers
  std::vector<Recording> recordings;
  std::vector<Setup> setups;
  std::vector<std::vector<EvaluatedRun>> runs;  ///< (setups x recordings)
  std::vector<std::size_t> jump_trials;         ///< of `recordings`: per choice of pads the one with the largest push

  std::size_t setup_markers(std::size_t setup) const { return setups[setup].config.bundle.scene.markers.size(); }
  bool has_measured_target() const;
};

/// Reads bundles and trials and builds every configuration, so that what is wrong comes out before anything runs.
/// Throws UsageError, config::ConfigError, protocol::FileError, protocol::MeshError.
class Evaluation {
 public:
  explicit Evaluation(const EvaluationRequest& request);

  std::size_t run_count() const { return jobs_.size(); }  ///< a session is one run

  /// Runs everything on `threads` threads, each run on one of them; results do not depend on how many there are, step
  /// times apart. on_done(done): after every run.
  void run(int threads, const std::function<void(std::size_t)>& on_done);

  const std::vector<std::unique_ptr<BundleEvaluation>>& bundles() const { return bundles_; }
  bool is_session() const { return session_; }

 private:
  // Recordings that one simulator is shown in turn.
  struct Job {
    BundleEvaluation* bundle;
    std::size_t setup;
    std::size_t recording;  // the first
    std::size_t count;
  };
  void run_job(const Job& job);

  bool pad_forces_, session_;
  std::vector<std::unique_ptr<BundleEvaluation>> bundles_;
  std::vector<Job> jobs_;
};

}  // namespace tissued::daemon
