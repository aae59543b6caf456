#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "protocol/fixed_list.hpp"
#include "protocol/tracker_frame.hpp"

// The UDP object stream of Vicon Tracker, and our own items in the same block layout (protocol/README.md has the byte
// tables). One datagram <-> one TrackerDatagram; frames that span datagrams are joined by FrameAssembler.

namespace tissued::protocol {

inline constexpr std::uint16_t kTrackerPort = 51001;
inline constexpr std::size_t kMaxTrackerDatagram = 1024;  // bytes

inline constexpr double kMaxPosition = 1e5;       // mm per axis; 100 m is no tracking volume
inline constexpr double kMaxRotation_rad = 10.0;  // per angle
inline constexpr double kMaxForce = 1e5;          // N per axis

enum class ItemId : std::uint8_t {
  object = 0x00,  // Vicon's own
  force = 0x46,   // 'F'
  marker = 0x4D,  // 'M'
  stamp = 0x54,   // 'T'
  truth = 0x58,   // 'X'
};

// Which part of a frame a datagram is, and when the tracker saw that frame.
struct FrameStamp {
  std::uint64_t stamp_ns = 0;  // tracker's clock
  std::uint8_t part = 0;       // 0 .. part_count - 1
  std::uint8_t part_count = 1;
};

// One decoded datagram; the capacities are what 1024 bytes can hold.
struct TrackerDatagram {
  std::uint32_t frame_number = 0;
  std::optional<FrameStamp> stamp;
  FixedList<TrackedObject, 13> objects;
  FixedList<TrackedMarker, 19> markers;
  FixedList<PadForce, 19> forces;
  FixedList<TargetTruth, 19> truth;
  std::uint8_t skipped_items = 0;  // items of ids we do not know, passed over by their size
};

// The gates in the order in which they are asked; the first that fails names the refusal. A datagram with one bad item
// is refused whole: its sender is broken, and half a frame would look like occlusion.
enum class TrackerRefusal : std::uint8_t {
  none,
  too_short,         // fewer bytes than frame number and item count
  too_long,          // more than kMaxTrackerDatagram
  truncated_item,    // an item reaches past the end
  wrong_item_size,   // a known id with another data size than its own
  bad_name,          // empty, not printable ASCII, or not zero-padded
  bad_flags,         // a marker flag that is not defined
  bad_stamp,         // part not below part count
  repeated_stamp,    // two stamp items in one datagram
  not_finite,        // NaN or infinity
  absurd_magnitude,  // beyond kMaxPosition, kMaxRotation_rad or kMaxForce
  trailing_bytes,    // anything but zero padding after the last item
};
inline constexpr std::size_t kTrackerRefusalCount = 12;

const char* to_string(TrackerRefusal refusal);

// Decodes one datagram. Where it refuses, `datagram` holds what was read so far and must not be used. No allocation.
TrackerRefusal decode_tracker_datagram(std::span<const std::uint8_t> bytes, TrackerDatagram& datagram);

// One datagram ready to be sent.
struct TrackerPacket {
  std::array<std::uint8_t, kMaxTrackerDatagram> bytes{};
  std::size_t size = 0;
  std::span<const std::uint8_t> view() const { return std::span(bytes).first(size); }
};

// A full TrackerFrame (32 objects, 128 markers, 32 forces, 64 truths) fits in this many datagrams.
inline constexpr std::size_t kMaxPacketsPerFrame = 16;

// Encodes a frame into as few datagrams as its items need, in the order objects, markers, forces, truth; every datagram
// carries a stamp item where the frame has a stamp, and none (plain Vicon) where it has none. A marker that is to go
// out as a Vicon object belongs into `frame.objects`. Returns how many packets were filled; 0, and nothing to be sent,
// where they are too few or a value would be refused by decode_tracker_datagram.
std::size_t encode_tracker_frame(const TrackerFrame& frame, std::span<TrackerPacket> packets);

}  // namespace tissued::protocol
