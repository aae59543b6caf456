#include "core/diagnosis/recorder.hpp"

#include <Eigen/Geometry>

namespace tissued::core {

namespace {

Mat3 rotation_matrix(const Vec3& rotation) {
  const double angle = rotation.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix() : Mat3(Mat3::Identity());
}

}  // namespace

RigidTransform misplaced(const MeasurementFaults& faults) { return {rotation_matrix(faults.rotation), faults.shift}; }

double& fault_number(MeasurementFaults& faults, int index) {
  if (index < 0) return faults.releases[static_cast<std::size_t>(-1 - index)];
  if (index == 0) return faults.latency;
  if (index < 4) return faults.rotation[index - 1];
  if (index < 7) return faults.shift[index - 4];
  return faults.slips[static_cast<std::size_t>((index - 7) / 3)].shift[(index - 7) % 3];
}

std::vector<std::string> fault_names(const std::vector<SlippedMarker>& slips, const Scene& scene) {
  std::vector<std::string> names{"latency.seconds"};
  const auto add_vector = [&names](const std::string& name) {
    for (const char* axis : {".x", ".y", ".z"}) names.push_back(name + axis);
  };
  add_vector("registration.rotation");
  add_vector("registration.shift");
  for (const SlippedMarker& slip : slips) add_vector("marker-slip." + scene.markers[slip.marker].name);
  return names;
}

RowMatrix recorded(const RecordedTrial& trial, int trial_index, const LoadPath& path, const Scene& scene,
                   const RowMatrix& answers, const MeasurementFaults& faults) {
  const Channels channels = channels_of(scene);
  const int seen = 3 * (channels.markers + channels.targets);
  RowMatrix out(trial.frame_count(), channels.count());
  const auto at = [&answers](const PathPlace& place, Eigen::Index begin, Eigen::Index count) {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(count);
    for (std::size_t k = 0; k < place.keys.size(); ++k)
      if (place.weights[k] != 0.0) sum += place.weights[k] * answers.row(place.keys[k]).segment(begin, count);
    return sum;
  };
  const bool has_release = static_cast<std::size_t>(trial_index) < faults.releases.size();
  const double release = has_release ? faults.releases[static_cast<std::size_t>(trial_index)] : 0.0;
  for (int f = 0; f < trial.frame_count(); ++f) {
    const double time = trial.time[f] - release;
    out.row(f).head(seen) = at(path.place(time - faults.latency), 0, seen);
    out.row(f).tail(channels.count() - seen) = at(path.place(time), seen, channels.count() - seen);
  }
  if (!faults.rotation.isZero() || !faults.shift.isZero()) {
    const RigidTransform seen_at = misplaced(faults);
    for (int i = 0; i < channels.markers + channels.targets; ++i) {
      const Vec3 rest = i < channels.markers ? scene.markers[i].rest : scene.targets[i - channels.markers].rest;
      for (int f = 0; f < trial.frame_count(); ++f) {
        auto moved = out.row(f).segment<3>(3 * i);
        moved = (seen_at(rest + Vec3(moved.transpose())) - rest).transpose().eval();
      }
    }
  }
  for (const SlippedMarker& slip : faults.slips) {
    if (slip.trial > trial_index) continue;
    for (int f = 0; f < trial.frame_count(); ++f)
      if (slip.trial < trial_index || trial.time[f] >= slip.time)
        out.row(f).segment<3>(channels.of_marker(slip.marker)) += slip.shift.transpose();
  }
  return out;
}

}  // namespace tissued::core
