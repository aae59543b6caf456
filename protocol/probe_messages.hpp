#pragma once

#include <array>
#include <cstdint>

#include "protocol/fixed_list.hpp"
#include "protocol/prediction_messages.hpp"

// What probes do to the tissue, and where targets are in their images.

namespace tissued::protocol {

// Asks for the newest answer about every probe; answered by ProbeViews, one probe after the other, all their parts, or
// by an error (not_available) where the scene has no probe.
struct QueryProbes {
  static constexpr MessageType kType = MessageType::query_probes;
};

// A target as an ultrasound image shows it.
struct ImageTarget {
  std::uint16_t index = 0;        // in the names table
  bool inside = false;            // the foot of the target on the plane lies within the image
  std::array<double, 2> pixel{};  // u along columns, v along rows; (0, 0) is the centre of the first pixel
  double distance = 0;            // mm, from the image's plane along its z
  double distance_sd = 0;         // mm
  std::array<double, 2> axes{};   // pixels: half axes of one standard deviation, the larger first
  double angle = 0;               // rad, of the larger one, from u towards v
};

// One probe after one tracker frame. Times ending in `_ns` are the daemon's monotonic clock. More than kTargetsPerPart
// targets go out in parts with equal scalars.
struct ProbeView {
  static constexpr MessageType kType = MessageType::probe_view;
  std::uint8_t part = 0;        // 0 .. part_count - 1
  std::uint8_t part_count = 1;  // datagrams about this probe, at most kMaxParts
  Validity validity = Validity::no_data;
  bool seen = false;          // by the tracker; what follows is zero and empty where it is not
  bool has_image = false;     // its calibration is known; targets are empty where it is not
  std::uint16_t reasons = 0;  // ValidityReason bits
  std::uint16_t index = 0;    // in the names table
  std::uint16_t probe_count = 1;
  std::uint32_t tracker_frame = 0;
  std::uint64_t receive_ns = 0;         // first datagram of the tracker frame
  std::uint64_t send_ns = 0;            // this datagram
  std::uint64_t age_ns = 0;             // of the tracker frame behind the answer, at send_ns
  std::array<double, 3> force{};        // N, tracker frame: of the probe on the tissue, as the simulator computes it
  std::array<std::uint16_t, 2> size{};  // pixels: columns, rows of the image; zero without
  std::array<double, 2> spacing{};      // mm/pixel; zero without

  static constexpr std::size_t kTargetsPerPart = 20;
  FixedList<ImageTarget, kTargetsPerPart> targets;
};

ClientRefusal read_body(ByteReader& reader, QueryProbes& message);
ClientRefusal read_body(ByteReader& reader, ProbeView& message);
void write_body(ByteWriter& writer, const QueryProbes& message);
void write_body(ByteWriter& writer, const ProbeView& message);

}  // namespace tissued::protocol
