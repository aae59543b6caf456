#include "daemon/evaluation_summary.hpp"

#include <cmath>

#include "daemon/duration_sample.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

// Mean over trials and targets of a score that counts once per compared frame.
class FrameMean {
 public:
  void add(double mean, std::size_t frames) {
    if (!std::isfinite(mean)) return;
    sum_ += mean * static_cast<double>(frames);
    frames_ += frames;
  }
  double mean() const { return frames_ > 0 ? sum_ / static_cast<double>(frames_) : NAN; }

 private:
  double sum_ = 0.0;
  std::size_t frames_ = 0;
};

// Everything of one setup that is pooled over its runs.
struct Pool {
  std::vector<double> first_holds, holds, errors;
  FrameMean square, inside, nees, inside_sensor, nees_sensor, innovation_square;
  DurationSample steps;
};

void add_target(const TargetScore& target, Pool& pool) {
  pool.holds.push_back(target.hold_mm);
  pool.square.add(target.rms_mm * target.rms_mm, target.frames);
  pool.inside.add(target.inside_95, target.frames);
  pool.nees.add(target.nees, target.frames);
  pool.inside_sensor.add(target.inside_95_sensor, target.frames);
  pool.nees_sensor.add(target.nees_sensor, target.frames);
}

void add_frames(const config::Bundle& bundle, const EvaluatedRun& run, Pool& pool) {
  for (const RunFrame& frame : run.recorded) {
    pool.steps.add(frame.step_time_ns);
    const double rms = frame.innovation_rms;
    pool.innovation_square.add(rms * rms, static_cast<std::size_t>(frame.markers_used));
    for (std::size_t target = 0; target < frame.targets.size(); ++target) {
      if (is_compared(bundle, frame, target)) pool.errors.push_back(frame.targets[target].error().norm());
    }
  }
}

}  // namespace

SetupSummary summarize(const BundleEvaluation& bundle, std::size_t setup) {
  Pool pool;
  SetupSummary summary{};
  for (const EvaluatedRun& run : bundle.runs[setup]) {
    if (!run.score.targets.empty()) pool.first_holds.push_back(run.score.targets.front().hold_mm);
    for (const TargetScore& target : run.score.targets) add_target(target, pool);
    add_frames(bundle.bundle, run, pool);
    summary.frames += run.score.frames;
    summary.diverged += run.score.diverged;
  }
  summary.first_hold_mm = finite_mean(pool.first_holds);
  summary.hold_mm = finite_mean(pool.holds);
  summary.rms_mm = std::sqrt(pool.square.mean());
  summary.p95_mm = percentile(pool.errors, 0.95);
  summary.max_mm = percentile(pool.errors, 1.0);
  summary.inside_95 = pool.inside.mean();
  summary.nees = pool.nees.mean();
  summary.inside_95_sensor = pool.inside_sensor.mean();
  summary.nees_sensor = pool.nees_sensor.mean();
  summary.innovation_rms_mm = std::sqrt(pool.innovation_square.mean());
  summary.step_p50_ms = pool.steps.percentile_ms(0.5);
  summary.step_p99_ms = pool.steps.percentile_ms(0.99);
  return summary;
}

std::string evaluation_summary(const Evaluation& evaluation) {
  TextTable table;
  table.add_row({"bundle", "model", "markers", "hold T[0] mm", "hold all mm", "rms mm", "p95 mm", "inside 95",
                 "with sensor", "step p50 ms", "p99 ms"});
  for (const auto& bundle : evaluation.bundles()) {
    for (std::size_t s = 0; s < bundle->setups.size(); ++s) {
      const SetupSummary summary = summarize(*bundle, s);
      table.add_row({bundle->bundle.scene.name, bundle->setups[s].model.name, bundle->setups[s].marker_set,
                     fixed(summary.first_hold_mm, 3), fixed(summary.hold_mm, 3), fixed(summary.rms_mm, 3),
                     fixed(summary.p95_mm, 3), fixed(summary.inside_95, 3), fixed(summary.inside_95_sensor, 3),
                     fixed(summary.step_p50_ms, 2), fixed(summary.step_p99_ms, 2)});
    }
  }
  return table.text();
}

}  // namespace tissued::daemon
