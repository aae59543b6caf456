#include "protocol/probe_messages.hpp"

#include <cmath>

namespace tissued::protocol {

namespace {

constexpr std::uint8_t kSeenFlag = 0x01, kImageFlag = 0x02;
constexpr std::uint8_t kInsideFlag = 0x01;
constexpr double kMostAngle = 1.5707963267948968;  // rad, a quarter of a turn and its rounding

bool read_target(ByteReader& reader, ImageTarget& target) {
  target.index = reader.u16();
  const std::uint8_t flags = reader.u8();
  const bool reserved_zero = reader.u8() == 0;
  target.inside = (flags & kInsideFlag) != 0;
  for (double& coordinate : target.pixel) coordinate = reader.f64();
  target.distance = reader.f64();
  target.distance_sd = reader.f64();
  for (double& axis : target.axes) axis = reader.f64();
  target.angle = reader.f64();
  return reserved_zero && (flags & ~kInsideFlag) == 0 && target.distance_sd >= 0 && target.axes[1] >= 0 &&
         target.axes[0] >= target.axes[1] && std::abs(target.angle) <= kMostAngle;
}

void write_target(ByteWriter& writer, const ImageTarget& target) {
  writer.u16(target.index);
  writer.u8(target.inside ? kInsideFlag : 0);
  writer.u8(0);
  for (const double coordinate : target.pixel) writer.f64(coordinate);
  writer.f64(target.distance);
  writer.f64(target.distance_sd);
  for (const double axis : target.axes) writer.f64(axis);
  writer.f64(target.angle);
}

// What is not known is zero.
bool is_consistent(const ProbeView& message) {
  const bool pushes = message.force != std::array<double, 3>{};
  if (!message.seen && (pushes || !message.targets.empty())) return false;
  if (message.has_image)
    return message.size[0] > 0 && message.size[1] > 0 && message.spacing[0] > 0 && message.spacing[1] > 0;
  return message.targets.empty() && message.size == std::array<std::uint16_t, 2>{} &&
         message.spacing == std::array<double, 2>{};
}

}  // namespace

ClientRefusal read_body(ByteReader&, QueryProbes&) { return ClientRefusal::none; }

void write_body(ByteWriter&, const QueryProbes&) {}

ClientRefusal read_body(ByteReader& reader, ProbeView& message) {
  message.part = reader.u8();
  message.part_count = reader.u8();
  message.validity = static_cast<Validity>(reader.u8());
  const std::uint8_t flags = reader.u8();
  message.seen = (flags & kSeenFlag) != 0;
  message.has_image = (flags & kImageFlag) != 0;
  message.reasons = reader.u16();
  message.index = reader.u16();
  message.probe_count = reader.u16();
  bool good = reader.u16() == 0 && (flags & ~(kSeenFlag | kImageFlag)) == 0;
  message.tracker_frame = reader.u32();
  message.receive_ns = reader.u64();
  message.send_ns = reader.u64();
  message.age_ns = reader.u64();
  message.force = reader.vector();
  for (std::uint16_t& pixels : message.size) pixels = reader.u16();
  for (double& spacing : message.spacing) spacing = reader.f64();
  const std::uint8_t target_count = reader.u8();
  good = reader.u8() == 0 && good;
  good = reader.u16() == 0 && good;
  if (!message.targets.resize(target_count)) return ClientRefusal::wrong_size;
  for (ImageTarget& target : message.targets) good = read_target(reader, target) && good;
  good = good && message.part < message.part_count && message.part_count <= kMaxParts;
  good = good && message.validity <= Validity::invalid && message.index < message.probe_count;
  return good && is_consistent(message) ? ClientRefusal::none : ClientRefusal::bad_value;
}

void write_body(ByteWriter& writer, const ProbeView& message) {
  writer.u8(message.part);
  writer.u8(message.part_count);
  writer.u8(static_cast<std::uint8_t>(message.validity));
  writer.u8(static_cast<std::uint8_t>((message.seen ? kSeenFlag : 0) | (message.has_image ? kImageFlag : 0)));
  writer.u16(message.reasons);
  writer.u16(message.index);
  writer.u16(message.probe_count);
  writer.u16(0);
  writer.u32(message.tracker_frame);
  writer.u64(message.receive_ns);
  writer.u64(message.send_ns);
  writer.u64(message.age_ns);
  writer.vector(message.force);
  for (const std::uint16_t pixels : message.size) writer.u16(pixels);
  for (const double spacing : message.spacing) writer.f64(spacing);
  writer.u8(static_cast<std::uint8_t>(message.targets.size()));
  writer.u8(0);
  writer.u16(0);
  for (const ImageTarget& target : message.targets) write_target(writer, target);
}

}  // namespace tissued::protocol
