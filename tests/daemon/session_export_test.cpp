// A recorded session becomes a bundle: what the tracker said stands in its trials, to the bit, push by push.
#include "daemon/session_export.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "daemon/recording.hpp"
#include "daemon/session_recorder.hpp"
#include "protocol/vicon_stream.hpp"
#include "tests/daemon/cube_bundle.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using namespace tissued::daemon;
using Bytes = std::vector<std::uint8_t>;

namespace {

constexpr std::size_t kFrames = 2500;
constexpr const char* kMarkers[] = {"M1", "M2", "M3", "M4"};
constexpr std::size_t kPush = 400, kLength = 150;  // frames from push to push, and of a push

// mm by which the pad is pushed in a frame: five pushes, a rest before each.
double depth_at(std::size_t frame) {
  const std::size_t k = frame % kPush;
  if (k < kPush - kLength) return 0.0;
  return 8.0 * std::sin(M_PI * static_cast<double>(k - (kPush - kLength) + 1) / (kLength + 1));
}

core::Vec3 marker_at(std::size_t frame, int marker) {
  return {20.0 + marker, 20.0 - 0.125 * depth_at(frame), 40.0 + 0.001 * static_cast<double>(frame)};
}

bool is_lost(std::size_t frame) { return frame % 97 == 50; }

// As tissued would have recorded it: some frames never came, a marker is hidden now and then.
Bytes recording(const config::Bundle& bundle, const std::string& more = "", const std::string& prefix = "") {
  protocol::SessionHeader header;
  header.scene = name_of("cube");
  header.bundle = bundle.folder.string();
  header.bundle_hash = hash_of_bundle(bundle);
  Bytes bytes(protocol::kSessionHeaderSize);
  write_session_header(header, bytes);
  const std::string text = R"({"format": "tissued-config/1", "bundle": ")" + bundle.folder.string() + "\"" + more + "}";
  Bytes configuration(protocol::kSessionRecordOverhead + text.size());
  protocol::write_session_record({protocol::SessionRecordKind::configuration, 1, Bytes(text.begin(), text.end())},
                                 configuration);
  bytes.insert(bytes.end(), configuration.begin(), configuration.end());
  for (std::size_t f = 0; f < kFrames; ++f) {
    if (is_lost(f)) continue;
    FrameBuilder frame(static_cast<std::uint32_t>(f + 1));
    frame.stamp((100 + f) * std::uint64_t{10'000'000});
    frame.pad("A1", core::Vec3(40.0 - depth_at(f), 20, 20)).force("A1", core::Vec3(-0.5, 0, 0.25));
    for (int m = 0; m < 4; ++m) frame.marker(prefix + kMarkers[m], marker_at(f, m), m == 2 && f % 10 == 3);
    std::array<protocol::TrackerPacket, protocol::kMaxPacketsPerFrame> packets;
    const std::size_t count = protocol::encode_tracker_frame(frame.frame, packets);
    for (std::size_t p = 0; p < count; ++p) {
      Bytes record(protocol::kSessionRecordOverhead + packets[p].size);
      protocol::write_session_record(
          {protocol::SessionRecordKind::tracker_datagram, (100 + f) * std::uint64_t{10'000'000} + p, packets[p].view()},
          record);
      bytes.insert(bytes.end(), record.begin(), record.end());
    }
  }
  return bytes;
}

void write(const std::filesystem::path& file, const Bytes& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

TEST_CASE("every push of a recorded session is a trial of the exported bundle") {
  const TemporaryFolder folder, work;
  const config::Bundle bundle = config::load_bundle(write_cube_bundle(folder));
  Bytes bytes = recording(bundle);
  const std::size_t whole = bytes.size();
  bytes.resize(whole - 5);  // killed in the midst of a record
  write(work.path() / "live.rec", bytes);
  const ExportReport report = export_session(work.path() / "live.rec", "", work.path() / "out");
  CHECK(report.torn);
  CHECK(report.damaged_bytes > 0);
  CHECK(report.frames + 1 >= kFrames - kFrames / 97 - 1);
  CHECK(report.trials.size() + report.held_out.size() == 6);
  CHECK(report.held_out == std::vector<std::string>{"live-004"});

  const config::Bundle out = config::load_bundle(work.path() / "out");
  CHECK(out.scene.name == bundle.scene.name);
  CHECK(out.trials.size() == 6);
  // The first push begins half a second after the margin's first frame.
  const protocol::Trial trial = read_trial(out.find_trial("live-001")->file);
  CHECK(trial.rate_hz == 100.0);
  const std::size_t begin = kPush - kLength;
  std::size_t first = begin;
  while (depth_at(first) <= 0.2) ++first;
  first -= 50;
  const std::size_t pad = trial.find_label("A1").value(), marker = trial.find_label("M3").value();
  CHECK(trial.frame_count >= kLength + 80);
  for (std::size_t f = 0; f < trial.frame_count; ++f) {
    CAPTURE(f);
    CHECK(trial.is_seen(f, pad) == !is_lost(first + f));
    CHECK(trial.is_seen(f, marker) == (!is_lost(first + f) && (first + f) % 10 != 3));
    if (trial.is_seen(f, marker)) CHECK(trial.position(f, marker) == array_of(marker_at(first + f, 2)));
    if (!trial.is_seen(f, pad)) continue;
    CHECK(trial.position(f, pad)[0] == 40.0 - depth_at(first + f));
    CHECK(trial.force(f, trial.find_device("A1").value())[2] == 0.25);
  }
}

TEST_CASE("names are read as the daemon read them") {
  const TemporaryFolder folder, work;
  const config::Bundle bundle = config::load_bundle(write_cube_bundle(folder));
  write(work.path() / "live.rec", recording(bundle, R"(, "tracker": {"subject": "cube7"})", "cube7:"));
  export_session(work.path() / "live.rec", "", work.path() / "out");
  const protocol::Trial trial = read_trial(config::load_bundle(work.path() / "out").find_trial("live-001")->file);
  CHECK(trial.is_seen(60, trial.find_label("M1").value()));
}

TEST_CASE("a recording of another bundle is not exported, nor over a bundle, nor what is none") {
  const TemporaryFolder folder, work;
  const config::Bundle bundle = config::load_bundle(write_cube_bundle(folder));
  const Bytes bytes = recording(bundle);
  write(work.path() / "live.rec", bytes);
  CHECK_THROWS_WITH(export_session(work.path() / "live.rec", "", folder.path()),
                    Catch::Matchers::Contains("holds a bundle already"));
  std::ofstream(folder.path() / "bundle.json", std::ios::app) << "\n";
  CHECK_THROWS_WITH(export_session(work.path() / "live.rec", "", work.path() / "out"),
                    Catch::Matchers::Contains("not the bundle"));
  write(work.path() / "none.rec", Bytes(3000, 7));
  CHECK_THROWS_WITH(export_session(work.path() / "none.rec", "", work.path() / "out"),
                    Catch::Matchers::Contains("bad_magic"));
  CHECK_FALSE(std::filesystem::exists(work.path() / "out"));
}
