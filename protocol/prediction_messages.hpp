#pragma once

#include <array>
#include <cstdint>

#include "protocol/alarm_state.hpp"
#include "protocol/client_header.hpp"
#include "protocol/fixed_list.hpp"

// Where the targets are, with how sure that is.

namespace tissued::protocol {

// Asks for the newest answer; answered by Predictions, all its parts.
struct QueryTargets {
  static constexpr MessageType kType = MessageType::query_targets;
};

enum class Validity : std::uint8_t {
  no_data = 0,   // nothing has come from the tracker yet: positions are the rest positions
  valid = 1,     // fresh and converged
  degraded = 2,  // usable with care: the reasons say why
  invalid = 3,   // the last good answer, held; its age grows
};

const char* to_string(Validity validity);

// Why an answer is not (quite) valid; a set of bits. Bits not listed are reserved and to be shown as unknown.
enum ValidityReason : std::uint16_t {
  kTrackerSilent = 1 << 0,      // the newest tracker frame is older than the stale limit
  kNotConverged = 1 << 1,       // ADMM stopped on its iteration limit
  kDiverged = 1 << 2,           // the step's result was thrown away
  kNoMarkers = 1 << 3,          // no marker was used: the filter only predicted
  kFewMarkers = 1 << 4,         // fewer markers than the config asks for
  kMarkersRejected = 1 << 5,    // an innovation gate threw markers out
  kPadMissing = 1 << 6,         // a pad in contact was not seen: its last pose is held
  kNotRegistered = 1 << 7,      // tracker and tissue coordinates are not registered yet
  kPartialFrame = 1 << 8,       // the tracker frame lacked datagrams
  kDeadlineMissed = 1 << 9,     // the step took longer than a frame
  kInvertedElements = 1 << 10,  // the mesh holds inverted elements
  kModelMismatch = 1 << 11,     // the alarm is raised: the assumed physics does not explain the markers
  kOverloaded = 1 << 12,        // steps take too long: fewer iterations than configured, then fewer meshes
  kStepBraked = 1 << 13,        // the step took so long that it was ended; its result was thrown away
};
inline constexpr std::size_t kValidityReasonCount = 14;

// Name of bit `bit` (0 .. 15); "unknown" for a reserved one.
const char* validity_reason_name(unsigned bit);

struct TargetPrediction {
  std::uint16_t index = 0;             // in the names table
  std::array<double, 3> position{};    // mm, tracker frame
  std::array<double, 6> covariance{};  // mm^2: xx, xy, xz, yy, yz, zz
  bool has_truth = false;
  std::array<double, 3> truth{};  // mm, tracker frame; relayed from the tracker for showing errors, zero without
};

struct PadReaction {
  std::uint16_t index = 0;        // in the names table
  std::array<double, 3> force{};  // N, tracker frame: force of the pad on the tissue, as the simulator computes it
};

inline constexpr std::uint8_t kMaxParts = 64;  // of an answer that does not fit one datagram

// The daemon's answer after one tracker frame. Times ending in `_ns` are the daemon's monotonic clock, except the
// tracker's own stamp. More than kTargetsPerPart targets or kPadsPerPart pads go out in parts with equal scalars.
struct Predictions {
  static constexpr MessageType kType = MessageType::predictions;
  std::uint8_t part = 0;        // 0 .. part_count - 1
  std::uint8_t part_count = 1;  // datagrams of this answer, at most kMaxParts
  Validity validity = Validity::no_data;
  bool has_stamp = false;
  std::uint16_t reasons = 0;  // ValidityReason bits
  std::uint32_t tracker_frame = 0;
  std::uint64_t stamp_ns = 0;      // tracker's clock; 0 without
  std::uint64_t receive_ns = 0;    // first datagram of the tracker frame
  std::uint64_t send_ns = 0;       // this datagram
  std::uint64_t age_ns = 0;        // of the tracker frame behind the answer, at send_ns
  std::uint64_t step_time_ns = 0;  // spent in the simulation step
  double primal_residual = 0;      // mm, ADMM, after the last iteration
  double dual_residual = 0;        // mm
  double innovation_rms = 0;       // mm, over the markers used, before the filter's correction
  AlarmState alarm;
  std::uint16_t iterations = 0;  // ADMM
  std::uint16_t markers_used = 0;
  std::uint16_t markers_seen = 0;  // in the tracker frame, not occluded

  static constexpr std::size_t kTargetsPerPart = 10;
  static constexpr std::size_t kPadsPerPart = 8;
  FixedList<TargetPrediction, kTargetsPerPart> targets;
  FixedList<PadReaction, kPadsPerPart> pads;
};

ClientRefusal read_body(ByteReader& reader, QueryTargets& message);
ClientRefusal read_body(ByteReader& reader, Predictions& message);
void write_body(ByteWriter& writer, const QueryTargets& message);
void write_body(ByteWriter& writer, const Predictions& message);

}  // namespace tissued::protocol
