// Markers of the past: straight lines between frames, and no further back than is remembered.
#include "core/marker_history.hpp"

#include <catch2/catch.hpp>

using namespace tissued::core;

namespace {

// Marker k moves by (k + 1) mm a frame, along x.
void add_frames(MarkerHistory& history, int first, int count, double dt) {
  for (int frame = first; frame < first + count; ++frame)
    history.add(std::vector<Vec3>{Vec3(frame, 0, 0), Vec3(2.0 * frame, 0, 0)}, dt);
}

}  // namespace

TEST_CASE("a marker has moved by what the simulation did since", "[marker_history]") {
  MarkerHistory history(2);
  std::vector<Vec3> moved(2);
  CHECK_FALSE(history.moved_since(0.0, moved));
  add_frames(history, 0, 5, 0.01);
  for (const double age : {0.0, 0.01, 0.015, 0.03, 0.04}) {
    REQUIRE(history.moved_since(age, moved));
    CHECK(moved[0].x() == Approx(age / 0.01).margin(1e-9));
    CHECK(moved[1].x() == Approx(2.0 * age / 0.01).margin(1e-9));
  }
  CHECK_FALSE(history.moved_since(0.0401, moved));
  CHECK_FALSE(history.moved_since(-0.01, moved));
  history.clear();
  CHECK_FALSE(history.moved_since(0.0, moved));
}

TEST_CASE("frames that came at odd times are found by their times", "[marker_history]") {
  MarkerHistory history(2);
  std::vector<Vec3> moved(2);
  add_frames(history, 0, 2, 0.01);
  add_frames(history, 2, 1, 0.04);  // one after a gap
  REQUIRE(history.moved_since(0.02, moved));
  CHECK(moved[0].x() == Approx(0.5));
  REQUIRE(history.moved_since(0.05, moved));
  CHECK(moved[0].x() == Approx(2.0));
}

TEST_CASE("what is older than the ring is gone", "[marker_history]") {
  MarkerHistory history(2);
  std::vector<Vec3> moved(2);
  const auto frames = static_cast<int>(MarkerHistory::kFrames);
  add_frames(history, 0, 3 * frames + 5, 0.01);
  REQUIRE(history.moved_since(0.01 * (frames - 1), moved));
  CHECK(moved[0].x() == Approx(frames - 1));
  CHECK_FALSE(history.moved_since(0.01 * frames, moved));
}
