#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "core/rest_calibration.hpp"
#include "core/simulator.hpp"
#include "daemon/pad_motion.hpp"
#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

struct TrackerSimulation {
  double rate_hz = 100.0;
  double noise = 0.1;    ///< mm, standard deviation per axis of every marker sample
  double dropout = 0.0;  ///< share of marker samples that are occluded, in gaps of 0.1 s on average
  double placement_error =
      0.5;  ///< mm, standard deviation per axis of where markers are glued against where they should
  PushPattern pattern = PushPattern::in_turn;
  double push = 12.0;   ///< mm, along each pad's direction
  double period = 4.0;  ///< s, of one push
  int iterations = 20;  ///< ADMM iterations a frame of the true tissue
  std::uint64_t seed = 1;
};

/// A tracking system beside a tissue, both simulated. The tissue is the core's open-loop simulator, told the truth: a
/// scene whose numbers may differ from what the daemon assumes. All its pads stay on the skin, pushing or not.
/// Equal arguments give equal frames, bit for bit.
class SimulatedTracker {
 public:
  /// tissue_from_tracker: where the frames' coordinates are. Throws core::ModelError for a scene that cannot be
  /// simulated, std::runtime_error for one whose names or numbers do not fit a tracker frame.
  SimulatedTracker(const core::Scene& truth, const core::RigidTransform& tissue_from_tracker,
                   const TrackerSimulation& simulation);

  /// Moves on by one frame and says what the tracker sees. Numbers begin at 1, stamps at 1 s.
  const protocol::TrackerFrame& next();

 private:
  void place_markers();
  void move_pads(double time);
  void see_markers();
  core::Vec3 gaussian(double standard_deviation);
  std::array<double, 3> in_tracker(const core::Vec3& tissue_position) const;

  TrackerSimulation simulation_;
  core::RigidTransform tracker_from_tissue_;
  std::unique_ptr<core::Simulator> tissue_;
  core::Observation observation_;
  std::vector<core::MaterialPoint> markers_;  // where they really are
  std::vector<std::uint8_t> occluded_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  protocol::TrackerFrame frame_;
};

}  // namespace tissued::daemon
