// Quasi-static pushes of an elastic body, as a tracker would have recorded them: solved once for each way in which pads
// push, then read off at any depth.
#pragma once

#include <optional>
#include <vector>

#include "core/diagnosis/session.hpp"
#include "tests/study/random.hpp"

namespace tissued::study {

// Pads that push together, each along its direction.
struct Push {
  std::vector<int> pads;
  std::vector<double> depths;  // mm, of each of these pads where the push is deepest
};

// Of all pads, those of the push at such a share of its depths.
std::vector<core::PadInput> pads_at(const core::Scene& scene, const Push& push, double share);

// Of a body, from rest to the deepest: channels as RecordedTrial::seen, without noise.
class PushCurve {
 public:
  // scene: the true one, in the elements that the truth is solved with. Nothing where Newton finds no equilibrium.
  static std::optional<PushCurve> solve(const core::Scene& scene, const Push& push);

  // share: of the deepest, 0 to 1.
  Eigen::RowVectorXd at(double share) const;

 private:
  std::vector<double> shares_;
  core::RowMatrix values_;
};

// Ramp, hold, release, rest.
struct Course {
  double share = 1.0;                         // of the push's deepest
  double ramp = 1.0, hold = 1.0, rest = 0.5;  // s; the way back takes as long as the way in

  double back() const { return 2.0 * ramp + hold; }  // s, when it is at rest again
  // Of the push's depths, at a time.
  double share_at(double time) const;
};

// Poses, and what is seen without noise; forces of pads that do not push are not seen.
core::RecordedTrial recorded_push(const core::Scene& scene, const std::string& name, const Push& push,
                                  const Course& course, const PushCurve& curve);

}  // namespace tissued::study
