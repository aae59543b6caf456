#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "protocol/fixed_list.hpp"
#include "protocol/name.hpp"

namespace tissued::protocol {

// A rigid object as Vicon Tracker streams it: a pad, a probe, or a labelled marker sent as an object.
struct TrackedObject {
  Name name;
  std::array<double, 3> position{};      // mm, tracker frame: the object's origin
  std::array<double, 3> rotation_rad{};  // Euler angles about x, y, z: tracker_R_object = Rx(x) * Ry(y) * Rz(z)
};

// A labelled marker. `position` means nothing where the marker is occluded.
struct TrackedMarker {
  Name name;
  std::array<double, 3> position{};  // mm, tracker frame
  bool occluded = false;
};

struct PadForce {
  Name name;                      // of the pad
  std::array<double, 3> force{};  // N, tracker frame: force of the pad on the tissue
};

// Where a simulated tracker or a player of recordings knows a target to be. It rides along only so that errors can be
// shown: whoever predicts must not read it.
struct TargetTruth {
  Name name;                         // of the target
  std::array<double, 3> position{};  // mm, tracker frame
};

// Why a frame was handed on.
enum class FrameCompletion : std::uint8_t {
  all_parts,   // every datagram that its stamp items announce has come
  all_names,   // no stamp item, but every expected name has come
  superseded,  // a datagram of a newer frame came first
  deadline,    // the frame's time was up
};

const char* to_string(FrameCompletion completion);

// Markers of an earlier frame that came after a newer frame had begun: cameras are slower than what drives the pads.
struct LateMarkers {
  std::uint32_t frame_number = 0;
  std::optional<std::uint64_t> stamp_ns;
  FixedList<TrackedMarker, 128> markers;
};

// All that the tracker said about one instant, joined from one or more datagrams. Trivially copyable, about 20 kB.
struct TrackerFrame {
  std::uint32_t frame_number = 0;
  std::optional<std::uint64_t> stamp_ns;  // tracker's clock; absent where the tracker sends none (plain Vicon)
  std::uint64_t receive_ns = 0;           // receiver's clock, at the first datagram
  FrameCompletion completion = FrameCompletion::all_parts;
  bool after_restart = false;  // first frame of a new numbering: differences to earlier frames mean nothing

  FixedList<TrackedObject, 32> objects;
  FixedList<TrackedMarker, 128> markers;
  FixedList<PadForce, 32> forces;
  FixedList<TargetTruth, 64> truth;
  LateMarkers late;  // those that have come since the last frame was handed on, of the newest frame among theirs
};

}  // namespace tissued::protocol
