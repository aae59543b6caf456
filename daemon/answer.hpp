#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/image_plane.hpp"
#include "core/simulator.hpp"
#include "protocol/fixed_list.hpp"

namespace tissued::daemon {

inline constexpr std::size_t kMaxMarkers = 128;  // as many as a protocol::TrackerFrame carries
inline constexpr std::size_t kMaxPads = 32;
inline constexpr std::size_t kMaxTargets = 64;
inline constexpr std::size_t kMaxProbes = 4;

/// Where one target is, tracker frame.
struct TargetPlace {
  std::array<double, 3> position{};            ///< mm
  std::array<double, 6> covariance{};          ///< mm2: xx, xy, xz, yy, yz, zz
  std::optional<std::array<double, 3>> truth;  ///< mm, relayed from the tracker
};

/// What a pad that touches the tissue does to it.
struct PadAnswer {
  std::uint16_t index = 0;        ///< in the scene
  std::array<double, 3> force{};  ///< N, tracker frame
};

/// What a probe does to the tissue, and what its image shows.
struct ProbeAnswer {
  bool seen = false;                                           ///< false: it does not touch, and the rest says nothing
  std::array<double, 3> force{};                               ///< N, tracker frame, of the probe on the tissue
  protocol::FixedList<core::ImagePoint, kMaxTargets> targets;  ///< (scene.targets) where the image is calibrated
};

/// Whether markers contradict the assumed physics: core::MismatchReport, in tracker coordinates, with its beginning.
struct AlarmAnswer {
  bool watching = false;  ///< enough has been seen to judge
  bool raised = false;    ///< a diagnosis is due
  double level = 0.0;     ///< evidence in units of what raises the alarm
  double misfit = 0.0;    ///< mm, RMS per axis, of the assumed physics at the markers
  bool has_place = false;
  std::array<double, 3> place{};  ///< mm, tracker: where a force would explain most of it; zero without
  std::uint32_t since_frame = 0;  ///< tracker frame that raised it; 0 while it is not raised
  std::uint64_t since_ns = 0;     ///< when that was received, monotonic clock
};

/// What the simulation knows after a step. Fixed in size, so that a LatestValue hands it on without allocating.
struct Answer {
  bool has_frame = false;  ///< false: no frame has been stepped yet, and targets are where they are at rest
  std::uint32_t tracker_frame = 0;
  std::optional<std::uint64_t> stamp_ns;  ///< tracker's clock
  std::uint64_t receive_ns = 0;           ///< monotonic clock, first datagram of the frame
  std::uint64_t delay_ns = 0;             ///< by which it was longer under way than the quickest: FrameInterval::delay
  std::uint64_t step_time_ns = 0;
  std::uint16_t reasons = 0;  ///< protocol::ValidityReason bits that do not depend on the answer's age
  int overload = 0;           ///< OverloadRule's level
  core::StepReport report;
  std::uint16_t markers_seen = 0;
  AlarmAnswer alarm;
  protocol::FixedList<TargetPlace, kMaxTargets> targets;  ///< (scene.targets)
  protocol::FixedList<PadAnswer, kMaxPads> pads;          ///< those that touch
  protocol::FixedList<ProbeAnswer, kMaxProbes> probes;    ///< (scene.probes)
};

/// All node positions at one moment.
struct MeshSnapshot {
  explicit MeshSnapshot(int node_count) : positions(static_cast<std::size_t>(node_count)) {}

  std::uint32_t tracker_frame = 0;
  std::uint64_t receive_ns = 0;
  std::vector<std::array<double, 3>> positions;  ///< (n) mm, tracker frame
};

}  // namespace tissued::daemon
