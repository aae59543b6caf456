#include "protocol/alarm_state.hpp"

namespace tissued::protocol {

namespace {

constexpr std::uint8_t kWatching = 0x01, kRaised = 0x02, kHasPlace = 0x04;

}  // namespace

bool read_alarm_state(ByteReader& reader, AlarmState& alarm) {
  const std::uint8_t flags = reader.u8();
  bool good = (flags & ~(kWatching | kRaised | kHasPlace)) == 0;
  good = reader.u8() == 0 && good;
  good = reader.u16() == 0 && good;
  alarm.watching = (flags & kWatching) != 0;
  alarm.raised = (flags & kRaised) != 0;
  alarm.has_place = (flags & kHasPlace) != 0;
  alarm.since_frame = reader.u32();
  alarm.since_ns = reader.u64();
  alarm.level = reader.f64();
  alarm.misfit = reader.f64();
  alarm.place = reader.vector();
  good = good && (alarm.raised || (alarm.since_frame == 0 && alarm.since_ns == 0));
  good = good && (alarm.has_place || alarm.place == std::array<double, 3>{});
  return good && alarm.level >= 0 && alarm.misfit >= 0;
}

void write_alarm_state(ByteWriter& writer, const AlarmState& alarm) {
  const int flags = (alarm.watching ? kWatching : 0) | (alarm.raised ? kRaised : 0) | (alarm.has_place ? kHasPlace : 0);
  writer.u8(static_cast<std::uint8_t>(flags));
  writer.u8(0);
  writer.u16(0);
  writer.u32(alarm.raised ? alarm.since_frame : 0);
  writer.u64(alarm.raised ? alarm.since_ns : 0);
  writer.f64(alarm.level);
  writer.f64(alarm.misfit);
  writer.vector(alarm.has_place ? alarm.place : std::array<double, 3>{});
}

}  // namespace tissued::protocol
