// Any bytes as a recording of a live session: what is read is in limits, lies in the file, and is read again from what
// is written of it; every byte belongs to the header, to one record, or to what is damaged.

#include <cmath>
#include <cstdint>
#include <vector>

#include "protocol/session_file.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

void check(const SessionRecord& record) {
  promise(record.body.size() <= kMaxSessionBody, "bodies are in limits");
  std::vector<std::uint8_t> bytes(kSessionRecordOverhead + record.body.size());
  promise(write_session_record(record, bytes) == bytes.size(), "what is read can be written");
  if (record.kind != SessionRecordKind::answer) return;
  const auto summary = read_answer_summary(record.body);
  if (!summary) return;
  std::vector<std::uint8_t> body(kMaxSessionBody);
  promise(write_answer_summary(*summary, body) == record.body.size(), "a summary is written as it was read");
}

void check_all(std::vector<std::uint8_t> bytes) {
  SessionReader reader(bytes);
  std::size_t whole = 0;
  while (const auto record = reader.next()) {
    check(*record);
    whole += kSessionRecordOverhead + record->body.size();
  }
  if (reader.refusal() != SessionRefusal::none) {
    promise(whole == 0, "nothing is read behind a header that is refused");
    return;
  }
  promise(kSessionHeaderSize + whole + reader.damaged_bytes() == bytes.size(), "every byte is counted once");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  check_all({data, data + size});
  // Once more behind a header that is right, and as the body of a record whose checksum is, which mutations rarely hit.
  std::vector<std::uint8_t> bytes(kSessionHeaderSize);
  SessionHeader header;
  header.scene = Name::from("demo").value();
  write_session_header(header, bytes);
  bytes.insert(bytes.end(), data, data + size);
  check_all(bytes);
  const SessionRecord record{SessionRecordKind::answer, 7, {data, size < kMaxSessionBody ? size : kMaxSessionBody}};
  check(record);
  return 0;
}
