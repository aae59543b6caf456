#pragma once

#include <array>
#include <cstdint>

#include "protocol/bytes.hpp"

namespace tissued::protocol {

// Whether the markers contradict the physics that is assumed: a part of predictions and of status.
struct AlarmState {
  bool watching = false;  // enough has been seen to judge
  bool raised = false;    // a diagnosis is due
  bool has_place = false;
  std::uint32_t since_frame = 0;  // tracker frame that raised it, as it was numbered then; 0 while it is not raised
  std::uint64_t since_ns = 0;     // when that frame was received, daemon's clock; 0 likewise
  double level = 0;               // evidence in units of what raises the alarm
  double misfit = 0;              // mm, RMS per axis, of the assumed physics at the markers
  std::array<double, 3> place{};  // mm, tracker frame: where a force would explain most of it; zero where not known
};

inline constexpr std::size_t kAlarmStateSize = 56;  // bytes

// False where a flag is not known, a reserved byte is not 0, or a value is beyond its limits. Leaves finiteness and
// size to the reader.
bool read_alarm_state(ByteReader& reader, AlarmState& alarm);
void write_alarm_state(ByteWriter& writer, const AlarmState& alarm);

}  // namespace tissued::protocol
