#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/alarm_state.hpp"
#include "protocol/fixed_list.hpp"
#include "protocol/name.hpp"

// What a running daemon records: every datagram that it received and a summary of every answer (protocol/README.md has
// the byte tables). The bytes are those of a file that may have been torn off or damaged anywhere.

namespace tissued::protocol {

inline constexpr std::uint32_t kSessionFileVersion = 2;
inline constexpr std::size_t kSessionHeaderSize = 1128;    // bytes
inline constexpr std::size_t kSessionPathCapacity = 1024;  // bytes
inline constexpr std::size_t kSessionRecordOverhead = 24;  // bytes, beside a record's body
inline constexpr std::size_t kMaxSessionBody = 4096;       // bytes

// Who recorded, and of what.
struct SessionHeader {
  std::uint64_t wall_ns = 0;       // since 1970, UTC, when recording began
  std::uint64_t monotonic_ns = 0;  // the daemon's clock at that instant: that of all stamps
  std::uint64_t bundle_hash = 0;   // FNV-1a over the bytes of bundle.json, then of the mesh
  Name scene;
  std::string bundle;  // folder, as an absolute path; cut off at its capacity
};

enum class SessionRecordKind : std::uint8_t {
  tracker_datagram = 1,  // as it came
  client_datagram = 2,   // likewise
  answer = 3,            // AnswerSummary
  lost = 4,              // uint64: records that found no room since the one before
  deadline = 5,          // empty: a frame that was not complete was handed on at this time
  configuration = 6,     // a piece of the configuration's JSON, first of all records; its last piece is the shorter one
  end = 7,               // uint64: hash of the simulation's state, where the daemon ended as it should
  part = 8,              // uint64: place among the files of one recording, from 2, of this one that goes on with it
};

// One record; the body lies in the bytes that were read.
struct SessionRecord {
  SessionRecordKind kind = SessionRecordKind::lost;
  std::uint64_t stamp_ns = 0;  // when it was received, daemon's clock; of an answer: when its frame was
  std::span<const std::uint8_t> body;
};

// What the daemon knew after a step. Where the step was thrown away that is what it knew before.
struct AnswerSummary {
  std::uint32_t stepped_frame = 0;  // the frame that was stepped; the record's stamp is when it was received
  std::uint32_t tracker_frame = 0;  // the one that the answer is about
  std::uint16_t reasons = 0;        // ValidityReason bits that do not depend on the answer's age
  std::uint16_t iterations = 0;
  std::uint16_t markers_used = 0;
  std::uint16_t markers_seen = 0;
  std::uint64_t step_time_ns = 0;
  double innovation_rms = 0;  // mm
  AlarmState alarm;
  FixedList<std::array<double, 3>, 64> targets;  // mm, tracker frame; in the scene's order
};

// Both return how many bytes they wrote: 0 where there is no room, or a number is not finite.
std::size_t write_session_header(const SessionHeader& header, std::span<std::uint8_t> out);
std::size_t write_session_record(const SessionRecord& record, std::span<std::uint8_t> out);
std::size_t write_answer_summary(const AnswerSummary& summary, std::span<std::uint8_t> out);
// Nothing where the body is none.
std::optional<AnswerSummary> read_answer_summary(std::span<const std::uint8_t> body);
// The number in a record that says what was lost, or the state at the end.
std::optional<std::uint64_t> read_number(std::span<const std::uint8_t> body);

enum class SessionRefusal : std::uint8_t { none, too_short, bad_magic, bad_version, bad_checksum, bad_value };
const char* to_string(SessionRefusal refusal);

// Reads from a whole file in memory, which must outlive the reader. Goes on behind what is damaged: the next place at
// which a record's marker, limits and checksum are right.
class SessionReader {
 public:
  explicit SessionReader(std::span<const std::uint8_t> bytes);

  // Other than none: there is nothing to read.
  SessionRefusal refusal() const { return refusal_; }
  const SessionHeader& header() const { return header_; }
  // The next record that is whole; nothing at the end.
  std::optional<SessionRecord> next();

  // So far: bytes that belong to no whole record, and how many stretches of them there were; of these the last may be
  // a torn tail.
  std::size_t damaged_bytes() const { return damaged_bytes_; }
  int damages() const { return damages_; }
  bool torn() const { return torn_; }

 private:
  void read_header();
  std::optional<SessionRecord> record_at(std::size_t offset) const;

  std::span<const std::uint8_t> bytes_;
  SessionRefusal refusal_ = SessionRefusal::none;
  SessionHeader header_;
  std::size_t next_ = 0, damaged_bytes_ = 0;
  int damages_ = 0;
  bool torn_ = false;
};

}  // namespace tissued::protocol
