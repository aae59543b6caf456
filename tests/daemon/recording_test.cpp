#include "daemon/recording.hpp"

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/daemon/recording_samples.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

const config::Bundle bundle = sample_bundle();

Recording sample_recording() { return {bundle, bundle.trials.front(), sample_trial()}; }

}  // namespace

TEST_CASE("A recorded frame becomes a tracker frame") {
  const Recording recording = sample_recording();
  protocol::TrackerFrame frame;
  REQUIRE(recording.fill(3, {}, frame));
  REQUIRE(frame.objects.size() == 1);
  CHECK(frame.objects[0].name.view() == "A1");
  CHECK(frame.objects[0].position == std::array<double, 3>{50, 0, 0});
  CHECK(frame.objects[0].rotation_rad == std::array<double, 3>{});
  REQUIRE(frame.markers.size() == 3);
  CHECK(frame.markers[1].name.view() == "M2");
  CHECK(frame.markers[1].occluded);
  CHECK_FALSE(frame.markers[0].occluded);
  CHECK(frame.forces.empty());
  REQUIRE(frame.truth.size() == 2);
  CHECK(frame.truth[1].position == std::array<double, 3>{4, 0, 30});

  REQUIRE(recording.fill(40, {}, frame));
  CHECK(frame.objects[0].position == std::array<double, 3>{42, 0, 0});
  CHECK(frame.truth.size() == 1);  // T2 is not seen in the hold
}

TEST_CASE("What goes into a frame can be chosen") {
  const Recording recording = sample_recording();
  protocol::TrackerFrame frame;
  RecordingItems items{bundle.find_marker_set("pair"), true, false};
  REQUIRE(recording.fill(40, items, frame));
  REQUIRE(frame.markers.size() == 2);
  CHECK(frame.markers[0].name.view() == "M1");
  CHECK(frame.markers[1].name.view() == "M3");
  CHECK(frame.truth.empty());
  REQUIRE(frame.forces.size() == 1);
  CHECK(frame.forces[0].force == std::array<double, 3>{-8, 0, 0});
  REQUIRE(recording.fill(5, items, frame));
  CHECK(frame.forces.empty());  // an empty cell is no force of zero
}

TEST_CASE("The hold is where the pad is at its largest push, its first fifth left out") {
  std::vector<std::size_t> expected;
  for (std::size_t frame = 33; frame < 50; ++frame) expected.push_back(frame);
  // Frame 29 is at 8 mm as well, so that 21 frames are held, of which 4 are left out.
  CHECK(sample_recording().hold() == expected);
  CHECK(sample_recording().opening_rest() == 10);
  REQUIRE(sample_recording().pushes().size() == 1);
  CHECK(sample_recording().pushes()[0].pad == 0);
  CHECK(sample_recording().pushes()[0].largest_mm == Approx(8.0));
}

TEST_CASE("Without a moving pad there is no hold") {
  protocol::Trial trial = sample_trial();
  for (std::size_t frame = 0; frame < trial.frame_count; ++frame) trial.positions[frame * 6 + 5] = {50, 0, 0};
  const Recording recording(bundle, bundle.trials.front(), trial);
  CHECK(recording.hold().empty());
  CHECK(recording.opening_rest() == 60);
}

TEST_CASE("A body that is held at first rests as long") {
  config::TrialInfo info = bundle.trials.front();
  info.held_until_frame = 4;
  CHECK(Recording(bundle, info, sample_trial()).opening_rest() == 4);
}

TEST_CASE("The push is measured in tissue coordinates") {
  config::Bundle turned = sample_bundle();
  turned.has_tracker_pose = true;
  turned.tissue_from_tracker.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  turned.tissue_from_tracker.translation = core::Vec3(7, 8, 9);
  protocol::Trial trial = sample_trial();
  const core::RigidTransform tracker_from_tissue = turned.tissue_from_tracker.inverse();
  for (auto& p : trial.positions) {
    const core::Vec3 q = tracker_from_tissue(core::Vec3(p[0], p[1], p[2]));
    p = {q.x(), q.y(), q.z()};
  }
  CHECK(Recording(turned, turned.trials.front(), trial).hold() == sample_recording().hold());
}

TEST_CASE("A recording of something else is refused") {
  protocol::Trial trial = sample_trial();
  for (auto& label : trial.labels) label += "x";
  CHECK_THROWS_WITH(Recording(bundle, bundle.trials.front(), trial),
                    "push.csv: holds no marker and no pad of the bundle sample");
  CHECK_THROWS_WITH(read_trial("push.txt"), Catch::Contains("push.txt") && Catch::Contains(".c3d"));
}

TEST_CASE("The recordings of table1 hold for half of their time") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "recordings/paper/table1";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: " << folder << " is not there");
    return;
  }
  const config::Bundle table1 = config::load_bundle(folder);
  for (const config::TrialInfo& info : table1.trials) {
    INFO(info.name);
    const Recording recording(table1, info, read_trial(info.file));
    CHECK(recording.frame_count() == 401);
    CHECK(recording.hold().size() > 100);
    CHECK(recording.target(recording.hold().front(), 0).has_value());
  }
}

TEST_CASE("The C3D recordings of the beam become frames of markers") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "real/beam";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: " << folder << " is not there");
    return;
  }
  const config::Bundle beam = config::load_bundle(folder);
  const config::TrialInfo* info = beam.find_trial("gravity");
  REQUIRE(info != nullptr);
  const Recording recording(beam, *info, read_trial(info->file));
  CHECK(recording.rate_hz() == 100.0);
  CHECK(recording.opening_rest() == 66);
  CHECK(recording.hold().empty());
  protocol::TrackerFrame frame;
  REQUIRE(recording.fill(0, {}, frame));
  CHECK(frame.markers.size() == 6);
  CHECK(frame.objects.empty());
}
