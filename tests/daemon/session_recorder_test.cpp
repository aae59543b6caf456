// What the daemon records of a live session: all that it received, byte for byte, and an answer for every step.
#include <catch2/catch.hpp>
#include <csignal>
#include <deque>
#include <random>

#include "daemon/session_recorder.hpp"
#include "protocol/file_content.hpp"
#include "tests/daemon/child_program.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace tissued::daemon;
using protocol::SessionRecordKind;
using Bytes = std::vector<std::uint8_t>;

namespace {

Bytes content_of(const std::filesystem::path& file) {
  const std::string text = protocol::read_file_content(file);
  return {text.begin(), text.end()};
}

// A file of the demo's size limit for the child, as a disk that fills up.
std::string limited(const std::string& command, int blocks) {
  return "ulimit -f " + std::to_string(blocks) + "; exec " + command;
}

config::DaemonConfig recording_config(const TemporaryFolder& folder) {
  config::DaemonConfig config = small_config();
  config.bundle.folder = write_cube_bundle(folder);
  config.bundle.mesh_file = folder.path() / "mesh.msh";
  config.record = folder.path() / "live.rec";
  return config;
}

}  // namespace

TEST_CASE("a ring hands records on in order, and refuses what has no room") {
  RecordRing ring(1000);
  std::deque<std::pair<std::uint64_t, Bytes>> waiting;  // by brute force
  std::mt19937 generator(2);
  std::size_t used = 0, refused = 0, passed = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    if (generator() % 2 == 0) {
      Bytes body(generator() % 300);
      for (std::uint8_t& byte : body) byte = static_cast<std::uint8_t>(generator());
      const bool fits = used + 16 + body.size() <= 1000;
      REQUIRE(ring.push(3, k, body) == fits);
      refused += fits ? 0 : 1;
      if (!fits) continue;
      used += 16 + body.size();
      waiting.emplace_back(k, body);
    } else {
      RecordRing::Entry entry;
      Bytes body(400);
      REQUIRE(ring.pop(entry, body) == !waiting.empty());
      if (waiting.empty()) continue;
      body.resize(entry.size);
      REQUIRE(entry.stamp_ns == waiting.front().first);
      REQUIRE(body == waiting.front().second);
      used -= 16 + body.size();
      waiting.pop_front();
      ++passed;
    }
  }
  CHECK(refused > 100);
  CHECK(passed > 1000);
}

TEST_CASE("two threads pass records through a ring without losing a byte") {
  RecordRing ring(4096);
  constexpr std::uint64_t kRecords = 20000;
  std::thread writer([&] {
    std::mt19937 generator(4);
    for (std::uint64_t k = 0; k < kRecords;) {
      const Bytes body(1 + generator() % 200, static_cast<std::uint8_t>(k));
      while (!ring.push(1, k, body)) std::this_thread::yield();
      ++k;
    }
  });
  std::mt19937 generator(4);
  std::size_t wrong = 0;
  Bytes body(256);
  for (std::uint64_t k = 0; k < kRecords; ++k) {
    RecordRing::Entry entry;
    while (!ring.pop(entry, body)) std::this_thread::yield();
    const bool right = entry.stamp_ns == k && entry.size == 1 + generator() % 200 &&
                       std::all_of(body.begin(), body.begin() + static_cast<std::ptrdiff_t>(entry.size),
                                   [k](std::uint8_t byte) { return byte == static_cast<std::uint8_t>(k); });
    wrong += right ? 0 : 1;
  }
  writer.join();
  CHECK(wrong == 0);
}

TEST_CASE("a recording holds every datagram as it came, and an answer for every step") {
  const TemporaryFolder folder;
  const config::DaemonConfig config = recording_config(folder);
  std::vector<Bytes> sent;
  int steps = 0;
  {
    RunningDaemon daemon(config);
    FakeTracker tracker(daemon.runtime.tracker_port());
    FakeClient client(daemon.runtime.client_port());
    for (std::uint32_t number = 1; number <= 40; ++number) {
      FrameBuilder frame(number);
      frame.stamp(number * std::uint64_t{10'000'000}).marker("M1", core::Vec3(0.1 * number, 0, 40));
      for (const auto& packet : FakeTracker::packets_of(frame.frame))
        sent.emplace_back(packet.view().begin(), packet.view().end());
      tracker.send(frame.frame);
      REQUIRE(eventually([&] { return daemon.simulator.steps == static_cast<int>(number); }));
    }
    const Bytes garbage{1, 2, 3};
    tracker.send(garbage);
    sent.push_back(garbage);
    client.ask<protocol::Status>(protocol::QueryStatus{});
    REQUIRE(eventually([&] { return daemon.count(Count::tracker_datagrams) == sent.size(); }));
    daemon.stop();
    steps = daemon.simulator.steps;
    CHECK(daemon.count(Count::records_lost) == 0);
    // One question, one piece of the configuration, and the end.
    CHECK(daemon.count(Count::records_written) == sent.size() + 1 + static_cast<std::size_t>(steps) + 2);
  }
  const Bytes bytes = content_of(config.record);
  protocol::SessionReader reader(bytes);
  REQUIRE(reader.refusal() == protocol::SessionRefusal::none);
  CHECK(reader.header().bundle_hash == hash_of_bundle(config.bundle));
  std::vector<Bytes> tracker;
  std::vector<protocol::AnswerSummary> answers;
  int clients = 0;
  std::uint64_t stamp = reader.header().monotonic_ns;
  while (const auto record = reader.next()) {
    if (record->kind == SessionRecordKind::tracker_datagram) {
      CHECK(record->stamp_ns >= stamp);
      stamp = record->stamp_ns;
      tracker.emplace_back(record->body.begin(), record->body.end());
    }
    if (record->kind == SessionRecordKind::client_datagram) ++clients;
    if (record->kind != SessionRecordKind::answer) continue;
    const auto summary = protocol::read_answer_summary(record->body);
    REQUIRE(summary);
    answers.push_back(*summary);
  }
  CHECK(reader.damaged_bytes() == 0);
  CHECK(tracker == sent);
  CHECK(clients == 1);
  REQUIRE(answers.size() == static_cast<std::size_t>(steps));
  for (std::size_t k = 0; k < answers.size(); ++k) {
    CHECK(answers[k].tracker_frame == k + 1);
    CHECK(answers[k].stepped_frame == k + 1);
    REQUIRE(answers[k].targets.size() == 2);
    CHECK(answers[k].targets[0][0] == Approx(5.0 + 0.1 * static_cast<double>(k + 1)));
  }
}

TEST_CASE("a recording that exists already is not written over, one in which nothing came is removed") {
  const TemporaryFolder folder;
  const config::DaemonConfig config = recording_config(folder);
  {
    RunningDaemon daemon(config);
    CHECK(std::filesystem::exists(config.record));
    FakeSimulator simulator;
    std::vector<std::string> told;
    {
      const Runtime another(config, simulator, [&](const std::string& line) { told.push_back(line); });
      CHECK(free_recording(config.record).filename() == "live-3.rec");
    }
    REQUIRE(told.size() == 1);
    CHECK(told[0].find("live-2.rec") != std::string::npos);
    Counters counters;
    CHECK_THROWS_AS(SessionRecorder(config.record, 1000, {}, "", counters, {}), std::system_error);
  }
  CHECK_FALSE(std::filesystem::exists(config.record));
  // Nor is it mixed with the later parts of one that is gone.
  std::ofstream(part_of_recording(config.record, 2)) << "x";
  CHECK(free_recording(config.record).filename() == "live-2.rec");
}

TEST_CASE("killed, the daemon leaves a recording of all but the last moment, on a full disk it serves on") {
  const TemporaryFolder folder;
  const std::string bundle = write_cube_bundle(folder).string();
  const std::string file = (folder.path() / "live.rec").string();
  const std::string command = std::string(TISSUED_BINARY) + " --bundle " + bundle + " --record " + file +
                              " --tracker-port 0 --client-port 0 --set alarm.enabled=false";
  const bool full = GENERATE(false, true);
  ChildProgram program("/bin/sh", {"-c", full ? limited(command, 16) : "exec " + command});  // 16 blocks: 8 or 16 kB
  unsigned tracker_port = 0, client_port = 0;
  REQUIRE(std::sscanf(program.read_line().c_str(), "listening tracker=%u clients=%u", &tracker_port, &client_port) ==
          2);
  FakeTracker tracker(static_cast<std::uint16_t>(tracker_port));
  FakeClient client(static_cast<std::uint16_t>(client_port));
  constexpr std::uint32_t kFrames = 150;
  for (std::uint32_t number = 1; number <= kFrames; ++number) {
    FrameBuilder frame(number);
    frame.stamp(number * std::uint64_t{10'000'000});
    for (const char* name : {"M1", "M2", "M3", "M4"}) frame.marker(name, core::Vec3(20, 20, 40));
    tracker.send(frame.frame);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  // It still answers, and says whether it still records.
  const auto names = client.ask<protocol::Names>(protocol::QueryNames{protocol::NameKind::counter});
  const auto status = client.ask<protocol::Status>(protocol::QueryStatus{});
  std::uint64_t failed = 99;
  for (const auto& counter : status.counters)
    if (counter.index < names.names.size() && names.names[counter.index].view() == "recording_failed")
      failed = counter.value;
  CHECK(failed == (full ? 1 : 0));
  program.signal(full ? SIGTERM : SIGKILL);
  const int code = program.wait();
  if (full) {
    CHECK(code == 0);
    CHECK(program.rest_of_stderr().find("recording ended") != std::string::npos);
  }
  const Bytes bytes = content_of(file);
  protocol::SessionReader reader(bytes);
  REQUIRE(reader.refusal() == protocol::SessionRefusal::none);
  std::uint32_t datagrams = 0;
  while (const auto record = reader.next()) datagrams += record->kind == SessionRecordKind::tracker_datagram ? 1 : 0;
  CHECK(reader.damaged_bytes() == 0);
  if (full) {
    CHECK(datagrams > 0);
    CHECK(datagrams < kFrames);
  } else {
    CHECK(datagrams == kFrames);
  }
}
