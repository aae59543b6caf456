#include "tests/study/pushes.hpp"

#include <algorithm>

#include "core/diagnosis/path_solver.hpp"

namespace tissued::study {

namespace {

constexpr int kLevels = 4;  // at which a push is solved; a quartic goes through them and rest

}  // namespace

std::vector<core::PadInput> pads_at(const core::Scene& scene, const Push& push, double share) {
  std::vector<core::PadInput> pads(scene.pads.size());
  for (std::size_t k = 0; k < push.pads.size(); ++k) {
    core::PadInput& pad = pads[push.pads[k]];
    pad.kind = core::PadInput::Kind::pose;
    pad.center = scene.pads[push.pads[k]].center + share * push.depths[k] * scene.pads[push.pads[k]].direction;
  }
  return pads;
}

std::optional<PushCurve> PushCurve::solve(const core::Scene& scene, const Push& push) {
  core::RecordedTrial way;
  way.time = {0.0, 1.0};
  way.pads = {pads_at(scene, push, 0.0), pads_at(scene, push, 1.0)};
  const double deepest = *std::max_element(push.depths.begin(), push.depths.end());
  const core::LoadPath path(way, scene, deepest / kLevels);
  core::PathSolver solver(scene, {});
  core::PathAnswer answer;
  if (!solver.solve(path, 0, {}, answer)) return std::nullopt;
  PushCurve curve;
  for (const core::LoadKey& key : path.keys()) curve.shares_.push_back(key.load / path.peak_load());
  curve.values_ = answer.values;
  return curve;
}

Eigen::RowVectorXd PushCurve::at(double share) const {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(values_.cols());
  for (std::size_t i = 0; i < shares_.size(); ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < shares_.size(); ++j)
      if (j != i) weight *= (share - shares_[j]) / (shares_[i] - shares_[j]);
    sum += weight * values_.row(static_cast<Eigen::Index>(i));
  }
  return sum;
}

double Course::share_at(double time) const {
  return share * std::clamp(std::min(time, back() - time) / ramp, 0.0, 1.0);
}

core::RecordedTrial recorded_push(const core::Scene& scene, const std::string& name, const Push& push,
                                  const Course& course, const PushCurve& curve) {
  const core::Channels channels = core::channels_of(scene);
  core::RecordedTrial trial;
  trial.name = name;
  const int frames = static_cast<int>((course.back() + course.rest) * scene.rate) + 1;
  trial.seen.resize(frames, channels.count());
  for (int f = 0; f < frames; ++f) {
    const double t = f / scene.rate;
    const double share = course.share_at(t);
    trial.time.push_back(t);
    trial.pads.push_back(pads_at(scene, push, share));
    trial.seen.row(f) = curve.at(share);
  }
  for (int pad = 0; pad < channels.pads; ++pad)
    if (std::find(push.pads.begin(), push.pads.end(), pad) == push.pads.end())
      trial.seen.middleCols<3>(channels.of_force(pad)).setConstant(std::numeric_limits<double>::quiet_NaN());
  return trial;
}

}  // namespace tissued::study
