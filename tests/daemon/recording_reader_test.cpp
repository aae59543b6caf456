#include "daemon/recording_reader.hpp"

#include <catch2/catch.hpp>
#include <fstream>

#include "daemon/session_recorder.hpp"
#include "tests/daemon/cube_bundle.hpp"

using namespace tissued;
using namespace tissued::daemon;
using protocol::SessionRecordKind;
using Bytes = std::vector<std::uint8_t>;

TEST_CASE("a last part of a recording that was created and not begun is a torn end") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "live.rec";
  protocol::SessionHeader header;
  header.scene = *protocol::Name::from("cube");
  Counters counters;
  SessionRecorder recorder(file, 1000, header, "{}", counters, {});
  for (int k = 0; k < 100; ++k) recorder.add_tracker(1 + k, Bytes(50, 7));
  recorder.stop();
  std::uint64_t parts = 1;
  while (std::filesystem::exists(part_of_recording(file, parts + 1))) ++parts;
  REQUIRE(parts > 1);
  for (std::uint64_t n = 1; n <= parts; ++n)
    CHECK(std::filesystem::file_size(part_of_recording(file, n)) > protocol::kSessionHeaderSize);
  const auto datagrams = [&](RecordingReader& reader) {
    int count = 0;
    while (const auto record = reader.next()) count += record->kind == SessionRecordKind::tracker_datagram ? 1 : 0;
    return count;
  };
  {
    RecordingReader whole(file);
    CHECK(whole.configuration() == "{}");
    CHECK(datagrams(whole) == 100);
    CHECK_FALSE(whole.torn());
  }
  std::ofstream(part_of_recording(file, parts + 1)).close();
  RecordingReader torn(file);
  CHECK(datagrams(torn) == 100);
  CHECK(torn.torn());
  CHECK(torn.parts() == parts);
  // In the middle it is a fault.
  std::ofstream(part_of_recording(file, parts + 2)).close();
  CHECK_THROWS_WITH(RecordingReader(file), Catch::Matchers::Contains("too_short"));
}
