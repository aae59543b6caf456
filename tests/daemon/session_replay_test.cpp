// What a daemon has recorded is repeated bit for bit, and what was changed since is found.
#include "daemon/session_replay.hpp"

#include <catch2/catch.hpp>
#include <fstream>
#include <memory>

#include "core/simulator.hpp"
#include "daemon/runtime.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/session_recorder.hpp"
#include "protocol/file_content.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace tissued::daemon;
using Bytes = std::vector<std::uint8_t>;

namespace {

constexpr std::uint32_t kFrames = 150;

// A push; now and then a frame is missing, or a part of it, so that only its deadline hands it on.
void track(std::uint16_t port) {
  FakeTracker tracker(port);
  for (std::uint32_t number = 1; number <= kFrames; ++number) {
    if (number % 37 == 0) continue;
    const double depth = number < 20 ? 0.0 : std::min(0.05 * (number - 20), 4.0);
    FrameBuilder frame(number);
    frame.stamp(number * std::uint64_t{10'000'000}).pad("A1", core::Vec3(40 - depth, 20, 20));
    frame.marker("M1", core::Vec3(20 - 0.3 * depth, 20, 40)).marker("M2", core::Vec3(10 - 0.2 * depth, 30, 40));
    frame.marker("M3", core::Vec3(30 - 0.5 * depth, 30, 40), number % 11 == 0);
    if (number % 23 == 0) {
      // Announces a second part, which never comes.
      auto packets = FakeTracker::packets_of(frame.frame);
      REQUIRE(packets.size() == 1);
      Bytes bytes(packets[0].view().begin(), packets[0].view().end());
      bytes[17] = 2;
      tracker.send(bytes);
    } else {
      tracker.send(frame.frame);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(number % 23 == 0 ? 8 : 2));
  }
}

config::DaemonConfig config_of(const std::filesystem::path& bundle, const std::filesystem::path& record) {
  return config::config_for_bundle(bundle,
                                   std::vector<std::string>{"alarm.enabled=false", "tracker.port=0", "clients.port=0",
                                                            "simulator.iterations=7", "record=" + record.string()});
}

// Returns the state in which the simulation ended.
std::uint64_t record(const config::DaemonConfig& config) {
  const auto simulator = core::make_simulator(load_scene(config.bundle), config.simulator);
  Runtime runtime(config, *simulator);
  std::thread thread([&] { runtime.run(); });
  track(runtime.tracker_port());
  runtime.stop();
  thread.join();
  CHECK(runtime.counters()[Count::records_lost] == 0);
  CHECK(runtime.counters()[protocol::AssemblerEvent::frames_deadline] > 2);
  return simulator->state_hash();
}

ReplayReport replay(const std::filesystem::path& file, const std::filesystem::path& bundle = {}) {
  return replay_session(file, bundle, [](std::size_t, std::size_t) {});
}

// The file with its records passed through `change`, which may alter a body.
template <typename Change>
void rewrite(const std::filesystem::path& file, const std::filesystem::path& out, Change change) {
  const std::string content = protocol::read_file_content(file);
  protocol::SessionReader reader(protocol::bytes_of(content));
  std::string written = content.substr(0, protocol::kSessionHeaderSize);
  while (const auto record = reader.next()) {
    Bytes body(record->body.begin(), record->body.end());
    if (!change(record->kind, body)) continue;
    Bytes bytes(protocol::kSessionRecordOverhead + body.size());
    protocol::write_session_record({record->kind, record->stamp_ns, body}, bytes);
    written.append(bytes.begin(), bytes.end());
  }
  protocol::write_file_content(out, written);
}

}  // namespace

TEST_CASE("A recorded run is repeated bit for bit, incomplete frames and all") {
  const TemporaryFolder folder;
  const config::DaemonConfig config = config_of(write_cube_bundle(folder), folder.path() / "live.rec");
  const std::uint64_t state = record(config);
  const ReplayReport report = replay(config.record);
  CHECK(report.steps > 100);
  CHECK(report.equal == report.steps);
  CHECK(report.frames >= report.steps);
  CHECK(report.recorded_hash == state);
  CHECK(report.state_hash == state);
  CHECK(report.is_same());
  CHECK_FALSE(report.torn);

  SECTION("killed: all answers that there are, and no state to compare with") {
    const std::string content = protocol::read_file_content(config.record);
    protocol::write_file_content(folder.path() / "torn.rec", content.substr(0, content.size() - 40));
    const ReplayReport torn = replay(folder.path() / "torn.rec");
    CHECK(torn.torn);
    CHECK_FALSE(torn.recorded_hash);
    CHECK(torn.equal == torn.steps);
    CHECK(torn.is_same());
  }
  SECTION("an answer with one other bit is found") {
    int answers = 0;
    rewrite(config.record, folder.path() / "other.rec", [&](protocol::SessionRecordKind kind, Bytes& body) {
      if (kind == protocol::SessionRecordKind::answer && ++answers == 50) body.back() ^= 1;
      return true;
    });
    const ReplayReport other = replay(folder.path() / "other.rec");
    CHECK(other.equal == other.steps - 1);
    CHECK(other.first_unequal.has_value());
    CHECK_FALSE(other.is_same());
  }
  SECTION("a datagram with one other bit changes what follows") {
    int datagrams = 0;
    rewrite(config.record, folder.path() / "other.rec", [&](protocol::SessionRecordKind kind, Bytes& body) {
      // A position's lowest bits, in the last item.
      if (kind == protocol::SessionRecordKind::tracker_datagram && ++datagrams == 60) body[body.size() - 20] ^= 1;
      return true;
    });
    const ReplayReport other = replay(folder.path() / "other.rec");
    CHECK(other.equal < other.steps);
    CHECK(other.state_hash != state);
  }
  SECTION("a datagram that is missing is said, with its frame") {
    int datagrams = 0;
    rewrite(config.record, folder.path() / "other.rec", [&](protocol::SessionRecordKind kind, Bytes&) {
      return kind != protocol::SessionRecordKind::tracker_datagram || ++datagrams != 60;
    });
    CHECK_THROWS_WITH(replay(folder.path() / "other.rec"), Catch::Contains("was stepped, but not all"));
  }
  SECTION("the configuration is the recorded one") {
    rewrite(config.record, folder.path() / "other.rec", [](protocol::SessionRecordKind kind, Bytes& body) {
      if (kind != protocol::SessionRecordKind::configuration) return true;
      std::string text(body.begin(), body.end());
      const std::size_t at = text.find("\"iterations\":7");
      REQUIRE(at != std::string::npos);
      text.replace(at, 14, "\"iterations\":3");
      body.assign(text.begin(), text.end());
      return true;
    });
    CHECK_FALSE(replay(folder.path() / "other.rec").is_same());
  }
  SECTION("a bundle that has moved is named; another one is refused") {
    const std::filesystem::path moved = folder.path() / "moved";
    std::filesystem::create_directory(moved);
    for (const char* file : {"bundle.json", "mesh.msh"}) std::filesystem::copy_file(folder.path() / file, moved / file);
    CHECK(replay(config.record, moved).is_same());
    std::ofstream(moved / "bundle.json", std::ios::app) << "\n";
    CHECK_THROWS_WITH(replay(config.record, moved), Catch::Contains("not the bundle"));
  }
}

TEST_CASE("A recording of several files is repeated as one") {
  const TemporaryFolder folder;
  config::DaemonConfig config = config_of(write_cube_bundle(folder), folder.path() / "live.rec");
  config.record_max_bytes = 20000;
  const std::uint64_t state = record(config);
  std::size_t parts = 1;
  while (std::filesystem::exists(part_of_recording(config.record, parts + 1))) ++parts;
  CHECK(parts > 3);
  CHECK(std::filesystem::file_size(part_of_recording(config.record, 2)) >= 20000);
  const ReplayReport report = replay(config.record);
  CHECK(report.steps > 100);
  CHECK(report.equal == report.steps);
  CHECK(report.state_hash == state);
  CHECK(report.is_same());

  // The last is of another recording; and without the second, the rest is not there.
  const auto other = config_of(folder.path(), folder.path() / "other.rec");
  record(other);
  std::filesystem::copy_file(other.record, part_of_recording(config.record, parts + 1));
  CHECK_THROWS_WITH(replay(config.record), Catch::Contains("belongs to another recording than"));
  std::filesystem::remove(part_of_recording(config.record, 2));
  CHECK_THROWS_WITH(replay(config.record), Catch::Contains("live.2.rec: is missing of the recording"));
}

TEST_CASE("What is no recording cannot be replayed") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(replay(folder.write("a.rec", "TSUDREC")), Catch::Contains("not a recording of tissued: too_short"));
  CHECK_THROWS_AS(replay(folder.path() / "missing.rec"), std::exception);
}
