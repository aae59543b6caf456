#include "core/diagnosis/seen_motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tissued::core {

namespace {

double distance(const PadInput& a, const PadInput& b) {
  if (a.kind != b.kind) return 1e9;
  if (a.kind == PadInput::Kind::absent) return 0.0;
  return (a.center - b.center).norm() + 10.0 * (a.rotation - b.rotation).norm();
}

// A channel about where it ends.
struct Swing {
  Eigen::Index channel = 0;
  double end = 0.0;     // mm, median of the trial's last tenth
  double square = 0.0;  // mm^2, summed
};

std::optional<Swing> swing_of(const RecordedTrial& trial, Eigen::Index channel) {
  std::vector<double> tail;
  const Eigen::Index frames = trial.seen.rows();
  for (Eigen::Index f = frames - frames / 10; f < frames; ++f)
    if (std::isfinite(trial.seen(f, channel))) tail.push_back(trial.seen(f, channel));
  if (tail.empty()) return std::nullopt;
  const auto middle = tail.begin() + static_cast<std::ptrdiff_t>(tail.size() / 2);
  std::nth_element(tail.begin(), middle, tail.end());
  Swing swing{channel, *middle};
  for (Eigen::Index f = 0; f < frames; ++f)
    if (std::isfinite(trial.seen(f, channel))) swing.square += std::pow(trial.seen(f, channel) - swing.end, 2);
  return swing;
}

std::optional<Swing> strongest_swing(const RecordedTrial& trial) {
  std::optional<Swing> strongest;
  for (Eigen::Index c = 0; c < trial.seen.cols(); ++c)
    if (const auto swing = swing_of(trial, c); swing && (!strongest || swing->square > strongest->square))
      strongest = swing;
  return strongest;
}

// s, when a channel passes where it ends, after the release.
std::vector<double> crossings_of(const RecordedTrial& trial, const Swing& swing, std::size_t most) {
  const double release = trial.motion ? trial.motion->release : trial.time.front();
  std::vector<double> crossings;
  double last = 0.0;
  for (Eigen::Index f = 0; f < trial.seen.rows() && crossings.size() < most; ++f) {
    const double now = trial.seen(f, swing.channel) - swing.end, time = trial.time[static_cast<std::size_t>(f)];
    if (time < release || !std::isfinite(now)) continue;
    if (last * now < 0.0) crossings.push_back(time);
    last = now;
  }
  return crossings;
}

}  // namespace

double largest_distance(const std::vector<PadInput>& a, const std::vector<PadInput>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, distance(a[i], b[i]));
  return largest;
}

double largest_displacement(const RecordedTrial& trial, const Scene& scene) {
  double largest = 0.0;
  const Channels channels = channels_of(scene);
  for (int i = 0; i < channels.markers; ++i) {
    std::vector<double> moved;
    for (Eigen::Index f = 0; f < trial.seen.rows(); ++f) {
      const double distance = trial.seen.row(f).segment<3>(channels.of_marker(i)).norm();
      if (std::isfinite(distance)) moved.push_back(distance);
    }
    if (moved.empty()) continue;
    const auto high = moved.begin() + static_cast<std::ptrdiff_t>(98 * moved.size() / 100);
    std::nth_element(moved.begin(), high, moved.end());
    largest = std::max(largest, *high);
  }
  return largest;
}

double calm_time(const RecordedTrial& trial, const Scene& scene, double peak) {
  constexpr double kNear = 0.1, kEnd = 0.1, kMargin = 0.2;  // of the peak, of the trial, s
  const int frames = trial.frame_count(), tail = std::max(1, static_cast<int>(kEnd * frames));
  double calm = trial.time.front();
  for (int f = 1; f < frames; ++f)
    if (largest_distance(trial.pads[f - 1], trial.pads[f]) > kStillSpeed * (trial.time[f] - trial.time[f - 1]))
      calm = trial.time[f];
  bool is_seen = false;
  for (int i = 0; i < static_cast<int>(scene.markers.size()); ++i) {
    const auto at = [&](int f) -> Vec3 { return trial.seen.row(f).segment<3>(3 * i).transpose(); };
    Vec3 end = Vec3::Zero();
    int count = 0;
    for (int f = frames - tail; f < frames; ++f)
      if (at(f).allFinite()) end += (at(f) - end) / ++count;
    if (count == 0) continue;
    is_seen = true;
    for (int f = 0; f < frames; ++f)
      if (at(f).allFinite() && (at(f) - end).norm() > kNear * peak) calm = std::max(calm, trial.time[f]);
  }
  return is_seen ? std::min(calm + kMargin, trial.time.back()) : trial.time.back();
}

double period_of(const RecordedTrial& trial) {
  constexpr double kUsual = 0.15;  // s
  constexpr std::size_t kMostCrossings = 6;
  const std::optional<Swing> swing = strongest_swing(trial);
  if (!swing) return kUsual;
  const std::vector<double> crossings = crossings_of(trial, *swing, kMostCrossings);
  if (crossings.size() < 3) return kUsual;
  return 2.0 * (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
}

}  // namespace tissued::core
