#include "core/diagnosis/load_path.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnosis/seen_motion.hpp"
#include "core/rigid_transform.hpp"

namespace tissued::core {

namespace {

constexpr double kFirstRestTime = 0.1;  // s after a pad stopped: the next key
constexpr double kRestGrowth = 2.2;     // each further one so many times as far
constexpr double kTimeWeight = 0.5;     // mm/s: in a hold answers are interpolated in time, in motion along the way
constexpr double kSamePose = 1e-6;      // mm

double load_of(const std::vector<PadInput>& pads, const Scene& scene) {
  double load = 0.0;
  for (std::size_t i = 0; i < pads.size(); ++i)
    if (pads[i].kind == PadInput::Kind::pose) load = std::max(load, (pads[i].center - scene.pads[i].center).norm());
  return load;
}

}  // namespace

PadInput between(const PadInput& a, const PadInput& b, double share) {
  if (a.kind != b.kind || share <= 0.0) return a;
  if (share >= 1.0) return b;
  PadInput pad = a;
  const RigidTransform pose = interpolate({a.rotation, a.center}, {b.rotation, b.center}, share);
  pad.rotation = pose.rotation;
  pad.center = pose.translation;
  pad.force = (1.0 - share) * a.force + share * b.force;
  return pad;
}

void LoadPath::read_frames(const RecordedTrial& trial) {
  double coordinate = 0.0;
  for (int f = 0; f < trial.frame_count(); ++f) {
    if (f > 0)
      coordinate += std::min(1e3, largest_distance(trial.pads[f - 1], trial.pads[f])) +
                    kTimeWeight * (trial.time[f] - trial.time[f - 1]);
    frames_.push_back({trial.time[f], load_of(trial.pads[f], *scene_), coordinate});
    peak_load_ = std::max(peak_load_, frames_.back().load);
  }
}

LoadPath::LoadPath(const RecordedTrial& trial, const Scene& scene, const MotionSteps& steps)
    : scene_(&scene), motion_(&trial.motion.value()) {
  constexpr double kLongest = 0.3, kGrowth = 1.6;  // s; of the steps while a body settles
  read_frames(trial);
  const double release = motion_->release, last = trial.time.back();
  peak_load_ = std::max(peak_load_, largest_displacement(trial, scene));
  for (Frame& frame : frames_) frame.load = frame.time < release ? frame.load : peak_load_;
  calm_from_ = steps.settles ? calm_time(trial, scene, peak_load_) : last;
  swings_until_ = std::min({last, release + steps.window, std::max(release, calm_from_)});
  add_key(trial, trial.time.front(), true);
  for (double time = release; time < swings_until_ - 0.5 * steps.finest; time += steps.finest)
    add_key(trial, time, time == release);
  if (swings_until_ > release) add_key(trial, swings_until_, true);
  double step = 4.0 * steps.finest;
  for (double time = swings_until_ + step; calm_from_ < last; time += step) {
    if (time > last - 0.5 * step) time = last;
    add_key(trial, time, false);
    keys_.back().settles = true;
    if (time == last) break;
    step = std::min(kLongest, kGrowth * step);
  }
  for (std::size_t k = 0; k < keys_.size(); ++k) keys_[k].pose = static_cast<int>(k);
  pose_count_ = static_cast<int>(keys_.size());
}

LoadPath::LoadPath(const RecordedTrial& trial, const Scene& scene, double travel) : scene_(&scene) {
  read_frames(trial);
  add_key(trial, trial.time.front(), true);
  double rest_begin = trial.time.front(), next_rest = kFirstRestTime;
  bool was_still = false;
  for (int f = 1; f < trial.frame_count(); ++f) {
    const double step = trial.time[f] - trial.time[f - 1];
    const double moved = largest_distance(trial.pads[f - 1], trial.pads[f]);
    const bool still = moved < kStillSpeed * step;
    if (still != was_still || moved > 1e8) {
      add_key(trial, trial.time[f - 1], true);
      rest_begin = trial.time[f - 1];
      next_rest = kFirstRestTime;
    }
    was_still = still;
    if (still) {
      if (trial.time[f] - rest_begin < next_rest) continue;
      add_key(trial, trial.time[f], false);
      next_rest *= kRestGrowth;
      continue;
    }
    // Levels of the load that were crossed: the same ones there and back.
    const double from = frames_[f - 1].load, to = frames_[f].load;
    std::vector<double> crossings;
    for (double level = travel * std::floor(std::min(from, to) / travel); level <= std::max(from, to);
         level += travel) {
      const double share = (level - from) / (to - from);
      if (share > 0.0 && share <= 1.0) crossings.push_back(share);
    }
    std::sort(crossings.begin(), crossings.end());
    for (double share : crossings) add_key(trial, trial.time[f - 1] + share * step, false);
  }
  add_key(trial, trial.time.back(), true);
  number_poses();
}

void LoadPath::add_key(const RecordedTrial& trial, double time, bool is_kink) {
  constexpr double kLeastStep = 1e-4;  // s
  if (!keys_.empty() && time < keys_.back().time + kLeastStep) {
    is_kink_.back() |= static_cast<std::uint8_t>(is_kink);
    return;
  }
  const auto after = std::upper_bound(trial.time.begin(), trial.time.end(), time);
  const std::size_t next = std::min<std::size_t>(after - trial.time.begin(), trial.time.size() - 1);
  const std::size_t last = next > 0 ? next - 1 : 0;
  const double span = trial.time[next] - trial.time[last];
  const double share = span > 0.0 ? std::min(1.0, (time - trial.time[last]) / span) : 0.0;
  LoadKey key;
  key.time = time;
  for (std::size_t p = 0; p < trial.pads[last].size(); ++p)
    key.pads.push_back(between(trial.pads[last][p], trial.pads[next][p], share));
  key.load = load_of(key.pads, *scene_);
  keys_.push_back(std::move(key));
  key_coordinates_.push_back(coordinate(time));
  is_kink_.push_back(is_kink);
}

void LoadPath::number_poses() {
  std::vector<const LoadKey*> poses;
  std::vector<PadInput> rest = keys_.front().pads;
  for (std::size_t p = 0; p < rest.size(); ++p) {
    rest[p].center = scene_->pads[p].center;
    rest[p].rotation.setIdentity();
  }
  LoadKey at_rest;
  at_rest.pads = rest;
  poses.push_back(&at_rest);
  for (LoadKey& key : keys_) {
    const auto same = std::find_if(poses.begin(), poses.end(), [&](const LoadKey* pose) {
      return largest_distance(pose->pads, key.pads) < kSamePose;
    });
    key.pose = static_cast<int>(same - poses.begin());
    if (same == poses.end()) poses.push_back(&key);
  }
  pose_count_ = static_cast<int>(poses.size());
}

double LoadPath::coordinate(double time) const {
  if (time <= frames_.front().time) return frames_.front().coordinate;
  const auto next = std::lower_bound(frames_.begin(), frames_.end(), time,
                                     [](const Frame& frame, double t) { return frame.time < t; });
  if (next == frames_.end()) return frames_.back().coordinate;
  const Frame& last = *(next - 1);
  return last.coordinate + (next->coordinate - last.coordinate) * (time - last.time) / (next->time - last.time);
}

PathPlace LoadPath::place(double time) const {
  const double at = coordinate(time);
  const int last = static_cast<int>(keys_.size()) - 1;
  const int next = static_cast<int>(std::upper_bound(key_coordinates_.begin(), key_coordinates_.end(), at) -
                                    key_coordinates_.begin());
  if (next == 0) return {{0, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}};
  if (next > last) return {{last, last, last, last}, {1.0, 0.0, 0.0, 0.0}};
  const int k = next - 1;
  const double span = key_coordinates_[next] - key_coordinates_[k], t = (at - key_coordinates_[k]) / span;
  PathPlace place{{std::max(0, k - 1), k, next, std::min(last, next + 1)}, {0.0, 0.0, 0.0, 0.0}};
  // Hermite: values at both ends and slopes there, of the chord across the end, or of the segment at a kink.
  place.weights[1] += (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t);
  place.weights[2] += t * t * (3.0 - 2.0 * t);
  const auto add_slope = [&](int end, double weight) {
    const bool is_first = end == k;
    const int from = is_first && !is_kink_[end] ? 0 : 1, to = is_first || is_kink_[end] ? 2 : 3;
    const double run = key_coordinates_[place.keys[to]] - key_coordinates_[place.keys[from]];
    place.weights[to] += weight * span / run;
    place.weights[from] -= weight * span / run;
  };
  add_slope(k, t * (1.0 - t) * (1.0 - t));
  add_slope(next, -t * t * (1.0 - t));
  return place;
}

std::size_t LoadPath::key_at_peak() const {
  std::size_t peak = 0;
  for (std::size_t k = 1; k < keys_.size(); ++k)
    if (keys_[k].load > keys_[peak].load + 1e-9) peak = k;
  return peak;
}

double LoadPath::load(double time) const {
  if (time <= frames_.front().time) return frames_.front().load;
  const auto next = std::lower_bound(frames_.begin(), frames_.end(), time,
                                     [](const Frame& frame, double t) { return frame.time < t; });
  if (next == frames_.end()) return frames_.back().load;
  const Frame& last = *(next - 1);
  return last.load + (next->load - last.load) * (time - last.time) / (next->time - last.time);
}

}  // namespace tissued::core
