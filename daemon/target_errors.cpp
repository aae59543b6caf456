#include "daemon/target_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace tissued::daemon {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class MeanPosition {
 public:
  void add(const core::Vec3& position) {
    sum_ += position;
    ++count_;
  }
  std::optional<core::Vec3> mean() const {
    if (count_ == 0) return std::nullopt;
    return core::Vec3(sum_ / static_cast<double>(count_));
  }

 private:
  core::Vec3 sum_ = core::Vec3::Zero();
  std::size_t count_ = 0;
};

std::optional<core::Vec3> predicted(const PlayedTrial& played, std::size_t frame, std::size_t daemon_index) {
  const FrameAnswer* found = played.find_answer(frame);
  if (found == nullptr) return std::nullopt;
  const auto& targets = found->answer.targets;
  const auto target = std::ranges::find(targets, daemon_index, &protocol::TargetPrediction::index);
  if (target == targets.end()) return std::nullopt;
  return core::Vec3(target->position[0], target->position[1], target->position[2]);
}

void compare_frames(const Recording& recording, const PlayedTrial& played, std::size_t target, std::size_t index,
                    TargetError& error) {
  double sum = 0.0;
  for (std::size_t frame = 0; frame < recording.frame_count(); ++frame) {
    const auto prediction = predicted(played, frame, index);
    const auto truth = recording.target(frame, target);
    if (!prediction || !truth) continue;
    sum += (*prediction - *truth).squaredNorm();
    ++error.frames;
  }
  if (error.frames > 0) error.rms_mm = std::sqrt(sum / static_cast<double>(error.frames));
}

double mean_of(const std::vector<TargetError>& errors, double TargetError::*value) {
  double sum = 0.0;
  int count = 0;
  for (const TargetError& error : errors) {
    if (!std::isfinite(error.*value)) continue;
    sum += error.*value;
    ++count;
  }
  return count > 0 ? sum / count : kNaN;
}

}  // namespace

double hold_error_mm(const Recording& recording, std::size_t target, const PredictedPlace& predicted_place) {
  MeanPosition prediction, truth;
  for (const std::size_t frame : recording.hold()) {
    if (const auto p = predicted_place(frame)) prediction.add(*p);
    if (const auto p = recording.target(frame, target)) truth.add(*p);
  }
  if (!prediction.mean() || !truth.mean()) return kNaN;
  return (*prediction.mean() - *truth.mean()).norm();
}

std::vector<TargetError> target_errors(const config::Bundle& bundle, const Recording& recording,
                                       const PlayedTrial& played, const std::vector<std::string>& daemon_names) {
  std::vector<TargetError> errors;
  for (std::size_t target = 0; target < bundle.scene.targets.size(); ++target) {
    const std::string& name = bundle.scene.targets[target].name;
    errors.push_back({name, kNaN, kNaN, 0});
    const auto known = std::ranges::find(daemon_names, name);
    if (known == daemon_names.end()) continue;
    const auto index = static_cast<std::size_t>(known - daemon_names.begin());
    errors.back().hold_mm =
        hold_error_mm(recording, target, [&](std::size_t frame) { return predicted(played, frame, index); });
    compare_frames(recording, played, target, index, errors.back());
  }
  return errors;
}

double mean_hold_mm(const std::vector<TargetError>& errors) { return mean_of(errors, &TargetError::hold_mm); }
double mean_rms_mm(const std::vector<TargetError>& errors) { return mean_of(errors, &TargetError::rms_mm); }

protocol::Trial predictions_as_trial(const config::Bundle& bundle, const Recording& recording,
                                     const PlayedTrial& played, const std::vector<std::string>& target_names,
                                     const std::vector<std::string>& pad_names) {
  const std::size_t frames = recording.frame_count();
  protocol::Trial trial;
  trial.rate_hz = recording.rate_hz();
  trial.first_frame = recording.first_frame();
  trial.frame_count = frames;
  trial.labels = target_names;
  trial.subjects.assign(target_names.size(), bundle.subject);
  trial.positions.assign(frames * target_names.size(), {kNaN, kNaN, kNaN});
  trial.seen.assign(frames * target_names.size(), 0);
  trial.devices = pad_names;
  trial.forces.assign(frames * pad_names.size(), {kNaN, kNaN, kNaN});
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const FrameAnswer* found = played.find_answer(frame);
    if (found == nullptr) continue;
    for (const auto& target : found->answer.targets) {
      if (target.index >= target_names.size()) continue;
      trial.positions[frame * target_names.size() + target.index] = target.position;
      trial.seen[frame * target_names.size() + target.index] = 1;
    }
    for (const auto& pad : found->answer.pads) {
      if (pad.index < pad_names.size()) trial.forces[frame * pad_names.size() + pad.index] = pad.force;
    }
  }
  return trial;
}

}  // namespace tissued::daemon
