#include "daemon/run_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "daemon/confidence.hpp"
#include "daemon/duration_sample.hpp"
#include "daemon/target_errors.hpp"

namespace tissued::daemon {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::array<double, 6> with_sensor(std::array<double, 6> covariance, double sensor_sd) {
  for (const std::size_t diagonal : {0, 3, 5}) covariance[diagonal] += sensor_sd * sensor_sd;
  return covariance;
}

double share_inside_95(std::span<const double> squares) {
  if (squares.empty()) return kNaN;
  const auto inside = std::ranges::count_if(squares, [](double square) { return square <= kChiSquare95; });
  return static_cast<double>(inside) / static_cast<double>(squares.size());
}

double root_mean_square(std::span<const double> values) {
  if (values.empty()) return kNaN;
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double hold_error(const Recording& recording, const TrialRun& run, std::size_t target) {
  return hold_error_mm(recording, target, [&](std::size_t index) -> std::optional<core::Vec3> {
    if (index >= run.size()) return std::nullopt;
    return run[index].targets[target].position;
  });
}

void add_normalized_squares(const config::Bundle& bundle, const TrialRun& run, std::size_t target,
                            NormalizedSquares& squares) {
  for (const RunFrame& frame : run) {
    if (!is_compared(bundle, frame, target)) continue;
    const TargetSample& sample = frame.targets[target];
    const auto square = normalized_square(sample.error(), sample.covariance);
    if (!square) continue;
    const auto widened = with_sensor(sample.covariance, bundle.noise.target);
    squares.claimed.push_back(*square);
    squares.with_sensor.push_back(normalized_square(sample.error(), widened).value());
  }
}

TargetScore score_target(const config::Bundle& bundle, const Recording& recording, const TrialRun& run,
                         std::size_t target) {
  std::vector<double> errors;
  for (const RunFrame& frame : run) {
    if (is_compared(bundle, frame, target)) errors.push_back(frame.targets[target].error().norm());
  }
  NormalizedSquares squares;
  add_normalized_squares(bundle, run, target, squares);
  TargetScore score;
  score.name = bundle.scene.targets[target].name;
  score.frames = errors.size();
  score.hold_mm = hold_error(recording, run, target);
  score.mean_mm = finite_mean(errors);
  score.rms_mm = root_mean_square(errors);
  score.p95_mm = percentile(errors, 0.95);
  score.max_mm = percentile(errors, 1.0);
  score.inside_95 = share_inside_95(squares.claimed);
  score.nees = finite_mean(squares.claimed);
  score.inside_95_sensor = share_inside_95(squares.with_sensor);
  score.nees_sensor = finite_mean(squares.with_sensor);
  return score;
}

// Every marker that was used counts alike, in whichever frame.
double innovation_rms(const TrialRun& run) {
  double sum = 0.0;
  int markers = 0;
  for (const RunFrame& frame : run) {
    sum += frame.innovation_rms * frame.innovation_rms * frame.markers_used;
    markers += frame.markers_used;
  }
  return markers > 0 ? std::sqrt(sum / markers) : kNaN;
}

}  // namespace

bool is_compared(const config::Bundle& bundle, const RunFrame& frame, std::size_t target) {
  return frame.targets[target].measured && (frame.contact || bundle.scene.pads.empty());
}

RunScore score_run(const config::Bundle& bundle, const Recording& recording, const TrialRun& run) {
  RunScore score;
  for (std::size_t target = 0; target < bundle.scene.targets.size(); ++target) {
    score.targets.push_back(score_target(bundle, recording, run, target));
  }
  DurationSample steps;
  for (const RunFrame& frame : run) {
    steps.add(frame.step_time_ns);
    score.diverged += frame.diverged ? 1 : 0;
  }
  score.frames = run.size();
  score.innovation_rms_mm = innovation_rms(run);
  score.step_p50_ms = steps.percentile_ms(0.5);
  score.step_p99_ms = steps.percentile_ms(0.99);
  return score;
}

NormalizedSquares normalized_squares(const config::Bundle& bundle, const TrialRun& run) {
  NormalizedSquares squares;
  for (std::size_t target = 0; target < bundle.scene.targets.size(); ++target) {
    add_normalized_squares(bundle, run, target, squares);
  }
  return squares;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return kNaN;
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto index = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(rank) - 1, 0, std::ssize(values) - 1);
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

double finite_mean(std::span<const double> values) {
  double sum = 0.0;
  int count = 0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? sum / count : kNaN;
}

}  // namespace tissued::daemon
