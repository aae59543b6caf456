#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "core/rest_calibration.hpp"
#include "core/simulator.hpp"
#include "daemon/pad_motion.hpp"
#include "daemon/probe_script.hpp"
#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

struct TrackerSimulation {
  double rate_hz = 100.0;
  double noise = 0.1;    ///< mm, standard deviation per axis of every marker sample
  double dropout = 0.0;  ///< share of marker samples that are occluded, in gaps of 0.1 s on average
  double placement_error =
      0.5;  ///< mm, standard deviation per axis of where markers are glued against where they should
  PushPattern pattern = PushPattern::in_turn;
  double push = 12.0;                 ///< mm, along each pad's direction
  double period = 4.0;                ///< s, of one push
  std::vector<ScriptedProbe> probes;  ///< that move; the scene's others are not seen
  double probe_depth = 8.0;           ///< mm, of a pressing probe's face below the skin at rest
  double probe_seconds = 1.5;         ///< s, of one of its moves
  int iterations = 20;                ///< ADMM iterations a frame of the true tissue
  std::uint64_t seed = 1;
};

/// A tracking system beside a tissue, both simulated. The tissue is the core's open-loop simulator, told the truth: a
/// scene whose numbers may differ from what the daemon assumes. All its pads stay on the skin, pushing or not.
/// Equal arguments give equal frames, bit for bit.
class SimulatedTracker {
 public:
  /// tissue_from_tracker: where the frames' coordinates are. Throws core::ModelError for a scene that cannot be
  /// simulated, std::runtime_error for one whose names or numbers do not fit a tracker frame, or that has no probe of
  /// a scripted one's name. images: (probes) as of config::Bundle; empty: none is known.
  SimulatedTracker(const core::Scene& truth, const core::RigidTransform& tissue_from_tracker,
                   const TrackerSimulation& simulation, std::span<const std::optional<core::ImagePlane>> images = {});

  /// Moves on by one frame and says what the tracker sees. Numbers begin at 1, stamps at 1 s.
  const protocol::TrackerFrame& next();

 private:
  void place_markers();
  void add_scripts(std::span<const std::optional<core::ImagePlane>> images);
  void move_pads(double time);
  void move_probes(double time);
  void see_markers();
  core::Vec3 gaussian(double standard_deviation);
  std::array<double, 3> in_tracker(const core::Vec3& tissue_position) const;

  TrackerSimulation simulation_;
  core::RigidTransform tracker_from_tissue_;
  std::unique_ptr<core::Simulator> tissue_;
  struct Script {
    std::size_t probe;   // in the scene
    std::size_t object;  // in the frame
    ProbeScript motion;
  };
  std::vector<Script> scripts_;
  core::Observation observation_;
  std::vector<core::MaterialPoint> markers_;  // where they really are
  std::vector<std::uint8_t> occluded_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  protocol::TrackerFrame frame_;
};

}  // namespace tissued::daemon
