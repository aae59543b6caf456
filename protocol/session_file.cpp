#include "protocol/session_file.hpp"

#include <algorithm>

#include "protocol/bytes.hpp"
#include "protocol/crc32c.hpp"

namespace tissued::protocol {

namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'T', 'S', 'U', 'D', 'R', 'E', 'C', '\n'};
constexpr std::array<std::uint8_t, 4> kMarker{0xD5, 'R', 'E', 'C'};
constexpr std::size_t kPrefix = 20;  // of a record: all before its body

bool is_kind(std::uint8_t kind) { return kind >= 1 && kind <= 8; }

void write_checksum(ByteWriter& writer, std::span<const std::uint8_t> written) { writer.u32(crc32c(written)); }

}  // namespace

const char* to_string(SessionRefusal refusal) {
  switch (refusal) {
    case SessionRefusal::none:
      return "none";
    case SessionRefusal::too_short:
      return "too_short";
    case SessionRefusal::bad_magic:
      return "bad_magic";
    case SessionRefusal::bad_version:
      return "bad_version";
    case SessionRefusal::bad_checksum:
      return "bad_checksum";
    case SessionRefusal::bad_value:
      return "bad_value";
  }
  return "unknown";
}

std::size_t write_session_header(const SessionHeader& header, std::span<std::uint8_t> out) {
  ByteWriter writer(out);
  writer.bytes(kMagic);
  writer.u32(kSessionFileVersion);
  writer.u32(kSessionHeaderSize);
  writer.u64(header.wall_ns);
  writer.u64(header.monotonic_ns);
  writer.u64(header.bundle_hash);
  writer.bytes(header.scene.padded());
  const std::size_t length = std::min(header.bundle.size(), kSessionPathCapacity);
  writer.u32(static_cast<std::uint32_t>(length));
  for (std::size_t i = 0; i < kSessionPathCapacity; ++i)
    writer.u8(i < length ? static_cast<std::uint8_t>(header.bundle[i]) : 0);
  for (std::size_t i = 0; i < 32; ++i) writer.u8(0);
  if (!writer.ok()) return 0;
  write_checksum(writer, out.first(writer.size()));
  return writer.ok() ? writer.size() : 0;
}

std::size_t write_session_record(const SessionRecord& record, std::span<std::uint8_t> out) {
  if (record.body.size() > kMaxSessionBody) return 0;
  ByteWriter writer(out);
  writer.bytes(kMarker);
  writer.u32(static_cast<std::uint32_t>(record.body.size()));
  writer.u8(static_cast<std::uint8_t>(record.kind));
  writer.u8(0);
  writer.u16(0);
  writer.u64(record.stamp_ns);
  writer.bytes(record.body);
  if (!writer.ok()) return 0;
  write_checksum(writer, out.first(writer.size()));
  return writer.ok() ? writer.size() : 0;
}

std::size_t write_answer_summary(const AnswerSummary& summary, std::span<std::uint8_t> out) {
  ByteWriter writer(out);
  writer.u32(summary.stepped_frame);
  writer.u32(summary.tracker_frame);
  writer.u16(summary.reasons);
  writer.u16(summary.iterations);
  writer.u16(summary.markers_used);
  writer.u16(summary.markers_seen);
  writer.u64(summary.step_time_ns);
  writer.f64(summary.innovation_rms);
  write_alarm_state(writer, summary.alarm);
  writer.u32(static_cast<std::uint32_t>(summary.targets.size()));
  for (const auto& target : summary.targets) writer.vector(target);
  return writer.ok() && writer.finite() ? writer.size() : 0;
}

std::optional<AnswerSummary> read_answer_summary(std::span<const std::uint8_t> body) {
  ByteReader reader(body);
  AnswerSummary summary;
  summary.stepped_frame = reader.u32();
  summary.tracker_frame = reader.u32();
  summary.reasons = reader.u16();
  summary.iterations = reader.u16();
  summary.markers_used = reader.u16();
  summary.markers_seen = reader.u16();
  summary.step_time_ns = reader.u64();
  summary.innovation_rms = reader.f64();
  const bool good_alarm = read_alarm_state(reader, summary.alarm);
  const std::uint32_t count = reader.u32();
  if (!reader.ok() || !good_alarm || !(summary.innovation_rms >= 0) || reader.remaining() != std::size_t{24} * count ||
      !summary.targets.resize(count))
    return std::nullopt;
  for (auto& target : summary.targets) target = reader.vector();
  return reader.finite() ? std::optional(summary) : std::nullopt;
}

std::optional<std::uint64_t> read_number(std::span<const std::uint8_t> body) {
  ByteReader reader(body);
  const std::uint64_t number = reader.u64();
  return reader.ok() && reader.remaining() == 0 ? std::optional(number) : std::nullopt;
}

SessionReader::SessionReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
  read_header();
  next_ = refusal_ == SessionRefusal::none ? kSessionHeaderSize : bytes_.size();
}

void SessionReader::read_header() {
  const auto refuse = [this](SessionRefusal refusal) { refusal_ = refusal; };
  if (bytes_.size() < kSessionHeaderSize) return refuse(SessionRefusal::too_short);
  ByteReader reader(bytes_.first(kSessionHeaderSize));
  if (!std::ranges::equal(reader.bytes(kMagic.size()), kMagic)) return refuse(SessionRefusal::bad_magic);
  if (reader.u32() != kSessionFileVersion) return refuse(SessionRefusal::bad_version);
  ByteReader checksum(bytes_.subspan(kSessionHeaderSize - 4, 4));
  if (checksum.u32() != crc32c(bytes_.first(kSessionHeaderSize - 4))) return refuse(SessionRefusal::bad_checksum);
  const bool right_size = reader.u32() == kSessionHeaderSize;
  header_.wall_ns = reader.u64();
  header_.monotonic_ns = reader.u64();
  header_.bundle_hash = reader.u64();
  const std::optional<Name> scene = Name::from_padded(reader.bytes(Name::kCapacity));
  const std::uint32_t length = reader.u32();
  const auto path = reader.bytes(kSessionPathCapacity);
  if (!right_size || !scene || length > kSessionPathCapacity) return refuse(SessionRefusal::bad_value);
  header_.scene = *scene;
  header_.bundle.assign(path.begin(), path.begin() + length);
}

std::optional<SessionRecord> SessionReader::record_at(std::size_t offset) const {
  ByteReader reader(bytes_.subspan(offset));
  if (!std::ranges::equal(reader.bytes(kMarker.size()), kMarker)) return std::nullopt;
  const std::uint32_t length = reader.u32();
  const std::uint8_t kind = reader.u8();
  const bool reserved_zero = (reader.u8() | reader.u16()) == 0;
  SessionRecord record;
  record.kind = static_cast<SessionRecordKind>(kind);
  record.stamp_ns = reader.u64();
  if (!reader.ok() || length > kMaxSessionBody || !is_kind(kind) || !reserved_zero) return std::nullopt;
  record.body = reader.bytes(length);
  const std::uint32_t checksum = reader.u32();
  if (!reader.ok() || checksum != crc32c(bytes_.subspan(offset, kPrefix + length))) return std::nullopt;
  return record;
}

std::optional<SessionRecord> SessionReader::next() {
  const std::size_t begin = next_;
  while (next_ < bytes_.size()) {
    if (auto record = record_at(next_)) {
      if (next_ > begin) ++damages_;
      damaged_bytes_ += next_ - begin;
      next_ += kSessionRecordOverhead + record->body.size();
      return record;
    }
    const auto rest = bytes_.subspan(next_ + 1);
    const auto marker = std::ranges::find(rest, kMarker[0]);
    next_ += 1 + static_cast<std::size_t>(marker - rest.begin());
  }
  if (next_ > begin) ++damages_;
  torn_ = torn_ || next_ > begin;
  damaged_bytes_ += next_ - begin;
  return std::nullopt;
}

}  // namespace tissued::protocol
