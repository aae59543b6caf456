// Recordings of a live session: what is written is read, whatever is torn off or damaged costs what it touches and
// nothing else.
#include "protocol/session_file.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <string_view>

#include "protocol/bytes.hpp"
#include "protocol/crc32c.hpp"
#include "tests/protocol/hex_bytes.hpp"

using namespace tissued::protocol;

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Written {
  SessionRecordKind kind;
  std::uint64_t stamp_ns;
  Bytes body;
  std::size_t end;  // in the file

  bool operator==(const SessionRecord& record) const {
    return kind == record.kind && stamp_ns == record.stamp_ns &&
           std::equal(body.begin(), body.end(), record.body.begin(), record.body.end());
  }
};

struct File {
  Bytes bytes;
  std::vector<Written> records;
};

AnswerSummary summary() {
  AnswerSummary answer;
  answer.stepped_frame = 1001;
  answer.tracker_frame = 1000;
  answer.reasons = 0x0804;
  answer.iterations = 10;
  answer.markers_used = 18;
  answer.markers_seen = 19;
  answer.step_time_ns = 1'800'000;
  answer.innovation_rms = 0.25;
  answer.alarm = {true, true, true, 990, 6'900'000'000, 1.5, 0.375, {1, -2, 3}};
  answer.targets.push_back({1.5, -2.5, 30});
  answer.targets.push_back({4, 5, 6});
  return answer;
}

SessionHeader header() {
  SessionHeader header;
  header.wall_ns = 1'700'000'000'000'000'000;
  header.monotonic_ns = 7'000'000'000;
  header.bundle_hash = 0x0123456789abcdef;
  header.scene = Name::from("demo").value();
  header.bundle = "/data/demo";
  return header;
}

Bytes record_bytes(SessionRecordKind kind, std::uint64_t stamp_ns, const Bytes& body) {
  Bytes buffer(kSessionRecordOverhead + body.size());
  REQUIRE(write_session_record({kind, stamp_ns, body}, buffer) == buffer.size());
  return buffer;
}

// Bodies of every kind, among them an empty one and one that holds the bytes of a record.
File sample() {
  File file;
  file.bytes.resize(kSessionHeaderSize);
  REQUIRE(write_session_header(header(), file.bytes) == kSessionHeaderSize);
  Bytes answer(kMaxSessionBody);
  answer.resize(write_answer_summary(summary(), answer));
  const Bytes inner = record_bytes(SessionRecordKind::lost, 1, Bytes(8, 1));
  const std::vector<std::pair<SessionRecordKind, Bytes>> all{{SessionRecordKind::tracker_datagram, {1, 2, 3, 0xD5}},
                                                             {SessionRecordKind::answer, answer},
                                                             {SessionRecordKind::client_datagram, {}},
                                                             {SessionRecordKind::tracker_datagram, inner},
                                                             {SessionRecordKind::lost, {7, 0, 0, 0, 0, 0, 0, 0}},
                                                             {SessionRecordKind::deadline, {}},
                                                             {SessionRecordKind::configuration, {'{', '}'}},
                                                             {SessionRecordKind::part, {2, 0, 0, 0, 0, 0, 0, 0}},
                                                             {SessionRecordKind::end, {1, 2, 3, 4, 5, 6, 7, 8}}};
  std::uint64_t stamp = 7'000'000'000;
  for (const auto& [kind, body] : all) {
    const Bytes bytes = record_bytes(kind, stamp, body);
    file.bytes.insert(file.bytes.end(), bytes.begin(), bytes.end());
    file.records.push_back({kind, stamp, body, file.bytes.size()});
    stamp += 10'000'000;
  }
  return file;
}

std::uint32_t checksum_of(std::string_view text) {
  return crc32c(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

}  // namespace

TEST_CASE("CRC-32C of known texts") {
  CHECK(checksum_of("123456789") == 0xE3069283);
  CHECK(checksum_of("") == 0);
  // RFC 3720, B.4.
  CHECK(crc32c(Bytes(32, 0x00)) == 0x8A9136AA);
  CHECK(crc32c(Bytes(32, 0xFF)) == 0x62A8AB43);
  Bytes ascending;
  for (std::uint8_t i = 0; i < 32; ++i) ascending.push_back(i);
  CHECK(crc32c(ascending) == 0x46DD794E);
  CHECK(crc32c(std::span(ascending).subspan(10), crc32c(std::span(ascending).first(10))) == 0x46DD794E);
}

TEST_CASE("what a session file holds is read back") {
  const File file = sample();
  SessionReader reader(file.bytes);
  REQUIRE(reader.refusal() == SessionRefusal::none);
  CHECK(reader.header().wall_ns == header().wall_ns);
  CHECK(reader.header().monotonic_ns == header().monotonic_ns);
  CHECK(reader.header().bundle_hash == header().bundle_hash);
  CHECK(reader.header().scene == header().scene);
  CHECK(reader.header().bundle == header().bundle);
  for (const Written& written : file.records) {
    const auto record = reader.next();
    REQUIRE(record);
    CHECK(written == *record);
  }
  CHECK_FALSE(reader.next());
  CHECK(reader.damaged_bytes() == 0);
  CHECK(reader.damages() == 0);
  CHECK_FALSE(reader.torn());
}

TEST_CASE("an answer's summary is read back, and no truncation of it is one") {
  Bytes body(kMaxSessionBody);
  body.resize(write_answer_summary(summary(), body));
  const auto read = read_answer_summary(body);
  REQUIRE(read);
  Bytes again(kMaxSessionBody);
  again.resize(write_answer_summary(*read, again));
  CHECK(again == body);
  CHECK(read->targets.size() == 2);
  CHECK(read->alarm.since_frame == 990);
  for (std::size_t size = 0; size < body.size(); ++size) CHECK_FALSE(read_answer_summary(std::span(body).first(size)));
  body.push_back(0);
  CHECK_FALSE(read_answer_summary(body));
  AnswerSummary wrong = summary();
  wrong.innovation_rms = std::numeric_limits<double>::quiet_NaN();
  CHECK(write_answer_summary(wrong, again) == 0);
}

TEST_CASE("the bytes are those of README.md") {
  Bytes body(8);
  ByteWriter(body).u64(7);
  CHECK(record_bytes(SessionRecordKind::lost, 2'500'000'000, body) == bytes_of_readme("record"));
}

TEST_CASE("every truncation of a session file leaves the whole records before it") {
  const File file = sample();
  for (std::size_t size = 0; size < file.bytes.size(); ++size) {
    const Bytes part(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(size));
    SessionReader reader(part);
    if (size < kSessionHeaderSize) {
      CHECK(reader.refusal() == SessionRefusal::too_short);
      CHECK_FALSE(reader.next());
      continue;
    }
    std::size_t end = kSessionHeaderSize;
    for (const Written& written : file.records) {
      if (written.end > size) break;
      const auto record = reader.next();
      REQUIRE(record);
      CHECK(written == *record);
      end = written.end;
    }
    // What is torn in the midst of a datagram that looks like a record: that one is whole, if it is all there.
    const bool inner_is_whole = end == file.records[2].end && size >= file.records[3].end - 4;
    if (!inner_is_whole) CHECK_FALSE(reader.next());
    while (reader.next()) {
    }
    if (!inner_is_whole) CHECK(reader.torn() == (size > end));
  }
}

TEST_CASE("every damaged byte of a session file costs the record it is in, or all where it is in the header") {
  const File file = sample();
  for (std::size_t offset = 0; offset < file.bytes.size(); ++offset) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes damaged = file.bytes;
      damaged[offset] = static_cast<std::uint8_t>(damaged[offset] ^ change);
      SessionReader reader(damaged);
      CAPTURE(offset, change);
      if (offset < kSessionHeaderSize) {
        CHECK(reader.refusal() != SessionRefusal::none);
        continue;
      }
      std::size_t begin = kSessionHeaderSize, lost = 0;
      for (const Written& written : file.records) {
        const bool touched = offset >= begin && offset < written.end;
        begin = written.end;
        lost += touched ? 1 : 0;
        if (touched) continue;
        auto record = reader.next();
        // A record inside of the damaged one may be read in its place.
        if (record && !(written == *record)) record = reader.next();
        REQUIRE(record);
        CHECK(written == *record);
      }
      CHECK(lost == 1);
      while (reader.next()) {
      }
      CHECK(reader.damages() >= 1);
    }
  }
}

TEST_CASE("a session file of another version, or of another program, is refused by name") {
  File file = sample();
  ++file.bytes[8];
  CHECK(SessionReader(file.bytes).refusal() == SessionRefusal::bad_version);
  file.bytes[0] = 'x';
  CHECK(SessionReader(file.bytes).refusal() == SessionRefusal::bad_magic);
  CHECK_FALSE(SessionReader(file.bytes).next());
}

TEST_CASE("bodies beyond the limit are not written, longer paths are cut off") {
  Bytes buffer(2 * kMaxSessionBody);
  const Bytes body(kMaxSessionBody + 1);
  CHECK(write_session_record({SessionRecordKind::answer, 1, body}, buffer) == 0);
  CHECK(write_session_record({SessionRecordKind::answer, 1, std::span(body).first(10)}, std::span(buffer).first(33)) ==
        0);
  SessionHeader longer = header();
  longer.bundle.assign(3000, 'p');
  buffer.resize(kSessionHeaderSize);
  REQUIRE(write_session_header(longer, buffer) == kSessionHeaderSize);
  CHECK(SessionReader(buffer).header().bundle == std::string(kSessionPathCapacity, 'p'));
}
