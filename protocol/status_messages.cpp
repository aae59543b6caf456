#include "protocol/status_messages.hpp"

namespace tissued::protocol {

ClientRefusal read_body(ByteReader&, QueryStatus&) { return ClientRefusal::none; }

void write_body(ByteWriter&, const QueryStatus&) {}

ClientRefusal read_body(ByteReader& reader, Status& message) {
  message.part = reader.u8();
  message.part_count = reader.u8();
  message.validity = static_cast<Validity>(reader.u8());
  const std::uint8_t count = reader.u8();
  message.reasons = reader.u16();
  message.subscribers = reader.u16();
  message.uptime_ns = reader.u64();
  message.send_ns = reader.u64();
  message.latency_p50_ns = reader.u64();
  message.latency_p99_ns = reader.u64();
  message.latency_max_ns = reader.u64();
  message.step_p50_ns = reader.u64();
  message.step_p99_ns = reader.u64();
  message.step_max_ns = reader.u64();
  message.tracker_rate_hz = reader.f64();
  message.step_rate_hz = reader.f64();
  const bool good_alarm = read_alarm_state(reader, message.alarm);
  if (!message.counters.resize(count)) return ClientRefusal::wrong_size;
  for (Counter& counter : message.counters) {
    counter.index = reader.u16();
    counter.value = reader.u64();
  }
  const bool good = good_alarm && message.part < message.part_count && message.part_count <= kMaxParts &&
                    message.validity <= Validity::invalid && message.tracker_rate_hz >= 0 && message.step_rate_hz >= 0;
  return good ? ClientRefusal::none : ClientRefusal::bad_value;
}

void write_body(ByteWriter& writer, const Status& message) {
  writer.u8(message.part);
  writer.u8(message.part_count);
  writer.u8(static_cast<std::uint8_t>(message.validity));
  writer.u8(static_cast<std::uint8_t>(message.counters.size()));
  writer.u16(message.reasons);
  writer.u16(message.subscribers);
  writer.u64(message.uptime_ns);
  writer.u64(message.send_ns);
  writer.u64(message.latency_p50_ns);
  writer.u64(message.latency_p99_ns);
  writer.u64(message.latency_max_ns);
  writer.u64(message.step_p50_ns);
  writer.u64(message.step_p99_ns);
  writer.u64(message.step_max_ns);
  writer.f64(message.tracker_rate_hz);
  writer.f64(message.step_rate_hz);
  write_alarm_state(writer, message.alarm);
  for (const Counter& counter : message.counters) {
    writer.u16(counter.index);
    writer.u64(counter.value);
  }
}

}  // namespace tissued::protocol
