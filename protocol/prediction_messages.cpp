#include "protocol/prediction_messages.hpp"

#include <algorithm>

namespace tissued::protocol {

namespace {

constexpr std::uint8_t kStampFlag = 0x01;
constexpr std::uint8_t kTruthFlag = 0x01;

constexpr std::array<const char*, kValidityReasonCount> kReasonNames{
    "tracker_silent",    "not_converged",  "diverged",       "no_markers",    "few_markers",
    "markers_rejected",  "pad_missing",    "not_registered", "partial_frame", "deadline_missed",
    "inverted_elements", "model_mismatch", "overloaded",     "step_braked"};

bool read_target(ByteReader& reader, TargetPrediction& target) {
  target.index = reader.u16();
  const std::uint8_t flags = reader.u8();
  const bool reserved_zero = reader.u8() == 0;
  target.position = reader.vector();
  for (double& entry : target.covariance) entry = reader.f64();
  target.has_truth = (flags & kTruthFlag) != 0;
  target.truth = reader.vector();
  const auto& [xx, xy, xz, yy, yz, zz] = target.covariance;
  const bool truth_good = target.has_truth || target.truth == std::array<double, 3>{};
  return (flags & ~kTruthFlag) == 0 && reserved_zero && xx >= 0 && yy >= 0 && zz >= 0 && truth_good;
}

void write_target(ByteWriter& writer, const TargetPrediction& target) {
  writer.u16(target.index);
  writer.u8(target.has_truth ? kTruthFlag : 0);
  writer.u8(0);
  writer.vector(target.position);
  for (const double entry : target.covariance) writer.f64(entry);
  writer.vector(target.has_truth ? target.truth : std::array<double, 3>{});
}

bool read_pad(ByteReader& reader, PadReaction& pad) {
  pad.index = reader.u16();
  const bool reserved_zero = reader.u16() == 0;
  pad.force = reader.vector();
  return reserved_zero;
}

void write_pad(ByteWriter& writer, const PadReaction& pad) {
  writer.u16(pad.index);
  writer.u16(0);
  writer.vector(pad.force);
}

}  // namespace

const char* to_string(Validity validity) {
  switch (validity) {
    case Validity::no_data:
      return "no_data";
    case Validity::valid:
      return "valid";
    case Validity::degraded:
      return "degraded";
    case Validity::invalid:
      return "invalid";
  }
  return "unknown";
}

const char* validity_reason_name(unsigned bit) { return bit < kReasonNames.size() ? kReasonNames[bit] : "unknown"; }

ClientRefusal read_body(ByteReader&, QueryTargets&) { return ClientRefusal::none; }

void write_body(ByteWriter&, const QueryTargets&) {}

ClientRefusal read_body(ByteReader& reader, Predictions& message) {
  message.part = reader.u8();
  message.part_count = reader.u8();
  message.validity = static_cast<Validity>(reader.u8());
  const std::uint8_t flags = reader.u8();
  message.has_stamp = (flags & kStampFlag) != 0;
  message.reasons = reader.u16();
  message.iterations = reader.u16();
  message.markers_used = reader.u16();
  message.markers_seen = reader.u16();
  message.tracker_frame = reader.u32();
  message.stamp_ns = reader.u64();
  message.receive_ns = reader.u64();
  message.send_ns = reader.u64();
  message.age_ns = reader.u64();
  message.step_time_ns = reader.u64();
  message.primal_residual = reader.f64();
  message.dual_residual = reader.f64();
  message.innovation_rms = reader.f64();
  const bool good_alarm = read_alarm_state(reader, message.alarm);
  const std::uint8_t target_count = reader.u8();
  const std::uint8_t pad_count = reader.u8();
  bool good = reader.u16() == 0 && good_alarm;
  if (!message.targets.resize(target_count) || !message.pads.resize(pad_count)) return ClientRefusal::wrong_size;
  for (TargetPrediction& target : message.targets) good = read_target(reader, target) && good;
  for (PadReaction& pad : message.pads) good = read_pad(reader, pad) && good;
  good = good && message.part < message.part_count && message.part_count <= kMaxParts;
  good = good && message.validity <= Validity::invalid;
  good = good && (flags & ~kStampFlag) == 0 && (message.has_stamp || message.stamp_ns == 0);
  good = good && message.primal_residual >= 0 && message.dual_residual >= 0 && message.innovation_rms >= 0;
  return good ? ClientRefusal::none : ClientRefusal::bad_value;
}

void write_body(ByteWriter& writer, const Predictions& message) {
  writer.u8(message.part);
  writer.u8(message.part_count);
  writer.u8(static_cast<std::uint8_t>(message.validity));
  writer.u8(message.has_stamp ? kStampFlag : 0);
  writer.u16(message.reasons);
  writer.u16(message.iterations);
  writer.u16(message.markers_used);
  writer.u16(message.markers_seen);
  writer.u32(message.tracker_frame);
  writer.u64(message.has_stamp ? message.stamp_ns : 0);
  writer.u64(message.receive_ns);
  writer.u64(message.send_ns);
  writer.u64(message.age_ns);
  writer.u64(message.step_time_ns);
  writer.f64(message.primal_residual);
  writer.f64(message.dual_residual);
  writer.f64(message.innovation_rms);
  write_alarm_state(writer, message.alarm);
  writer.u8(static_cast<std::uint8_t>(message.targets.size()));
  writer.u8(static_cast<std::uint8_t>(message.pads.size()));
  writer.u16(0);
  for (const TargetPrediction& target : message.targets) write_target(writer, target);
  for (const PadReaction& pad : message.pads) write_pad(writer, pad);
}

}  // namespace tissued::protocol
