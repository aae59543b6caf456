#include "daemon/pad_tracker.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <numbers>
#include <vector>

#include "daemon/rest_gate.hpp"

using namespace tissued;
using core::Mat3;
using core::Vec3;
using daemon::PadTracker;
using daemon::RestGate;
using Kind = core::PadInput::Kind;

namespace {

constexpr double kTolerance = 0.2;  // mm
const Vec3 kCenter(50, 0, 30);
const core::RigidTransform kIdentity;

struct OnePad {
  PadTracker tracker;
  std::vector<core::PadInput> inputs = std::vector<core::PadInput>(1);
  int held = 0;

  explicit OnePad(bool learn_offsets = false)
      : tracker({{"A1", "A1", kCenter, Vec3(-1, 0, 0)}}, kTolerance, 0.5, learn_offsets) {
    tracker.begin_frame();
  }
  const core::PadInput& finish(double elapsed = 0.01, bool whole = true, const core::RigidTransform& t = kIdentity) {
    held = tracker.finish_frame(elapsed, whole, t, true, inputs);
    tracker.begin_frame();
    return inputs[0];
  }
};

Mat3 turn(double degrees, const Vec3& axis) {
  return Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()).toRotationMatrix();
}

}  // namespace

TEST_CASE("A pad never seen is absent, one seen is a pose in tissue coordinates") {
  OnePad pad;
  CHECK(pad.finish().kind == Kind::absent);
  core::RigidTransform t{turn(90, Vec3::UnitZ()), Vec3(1, 2, 3)};
  pad.tracker.see_pose(0, Vec3(10, 0, 0), turn(20, Vec3::UnitX()));
  const core::PadInput& input = pad.finish(0.01, true, t);
  CHECK(input.kind == Kind::pose);
  CHECK(input.center.isApprox(Vec3(1, 12, 3)));
  // Never seen at rest: a turn about the tracker's x is a turn about the tissue's y.
  CHECK(input.rotation.isApprox(turn(20, Vec3::UnitY())));
  CHECK(pad.held == 0);
}

TEST_CASE("A pad that is lost is held for 100 ms and lifted after that") {
  OnePad pad;
  pad.tracker.see_pose(0, Vec3(40, 0, 30), Mat3::Identity());
  pad.finish();
  for (int frame = 1; frame <= 9; ++frame) {
    CHECK(pad.finish().kind == Kind::pose);
    CHECK(pad.inputs[0].center == Vec3(40, 0, 30));
    CHECK(pad.held == 1);
  }
  pad.finish(0.005);
  CHECK(pad.inputs[0].kind == Kind::pose);
  CHECK(pad.finish(0.01).kind == Kind::absent);
  CHECK(pad.held == 1);  // it was pushing: lifted is a guess
  pad.tracker.see_pose(0, Vec3(41, 0, 30), Mat3::Identity());
  CHECK(pad.finish().kind == Kind::pose);
}

TEST_CASE("A pad that was lost while it pushed is missing until it is seen again or the tracker begins anew") {
  OnePad pad;
  const bool begins_anew = GENERATE(false, true);
  pad.tracker.see_pose(0, Vec3(40, 0, 30), Mat3::Identity());
  for (int frame = 0; frame < 50; ++frame) {
    pad.finish();
    CHECK(pad.held == (frame > 0 ? 1 : 0));
    CHECK_FALSE(pad.tracker.at_rest(kIdentity, true));
  }
  begins_anew ? pad.tracker.restart() : pad.tracker.see_pose(0, kCenter, Mat3::Identity());
  CHECK(pad.tracker.at_rest(kIdentity, true));
  for (int frame = 0; frame < 20; ++frame) pad.finish();
  CHECK(pad.held == 0);
  CHECK(pad.tracker.at_rest(kIdentity, true));
}

TEST_CASE("Frames with lost datagrams never lift a pad") {
  OnePad pad;
  pad.tracker.see_pose(0, Vec3(40, 0, 30), Mat3::Identity());
  pad.finish();
  for (int frame = 0; frame < 50; ++frame) CHECK(pad.finish(0.01, false).kind == Kind::pose);
  CHECK(pad.finish(0.01, true).kind == Kind::absent);
}

TEST_CASE("A pad with a force and no pose is a force, turned into tissue coordinates") {
  OnePad pad;
  const core::RigidTransform t{turn(90, Vec3::UnitZ()), Vec3(1, 2, 3)};
  pad.tracker.see_force(0, Vec3(2, 0, 0));
  const core::PadInput& input = pad.finish(0.01, true, t);
  CHECK(input.kind == Kind::force);
  CHECK(input.force.isApprox(Vec3(0, 2, 0)));
  for (int frame = 0; frame < 9; ++frame) CHECK(pad.finish().kind == Kind::force);
  CHECK(pad.held == 1);
  pad.finish();
  CHECK(pad.finish().kind == Kind::absent);
}

TEST_CASE("A pose rules over a force beside it, also while the pose is held") {
  OnePad pad;
  pad.tracker.see_force(0, Vec3(2, 0, 0));
  pad.tracker.see_pose(0, Vec3(40, 0, 30), Mat3::Identity());
  CHECK(pad.finish().kind == Kind::pose);
  for (int frame = 0; frame < 9; ++frame) {
    pad.tracker.see_force(0, Vec3(2, 0, 0));
    CHECK(pad.finish().kind == Kind::pose);
  }
  pad.tracker.see_force(0, Vec3(2, 0, 0));
  pad.finish();
  pad.tracker.see_force(0, Vec3(2, 0, 0));
  CHECK(pad.finish().kind == Kind::force);
}

TEST_CASE("At rest: within the tolerance of the said center, or a force that is noise") {
  OnePad pad;
  CHECK(pad.tracker.at_rest(kIdentity, true));  // not seen
  pad.tracker.see_pose(0, kCenter + Vec3(0, 0.19, 0), Mat3::Identity());
  CHECK(pad.tracker.at_rest(kIdentity, true));
  pad.tracker.see_pose(0, kCenter + Vec3(0, 0.21, 0), Mat3::Identity());
  CHECK_FALSE(pad.tracker.at_rest(kIdentity, true));
  pad.tracker.begin_frame();
  pad.tracker.see_force(0, Vec3(0.01, 0, 0));
  CHECK(pad.tracker.at_rest(kIdentity, true));
  pad.tracker.see_force(0, Vec3(0.1, 0, 0));
  CHECK_FALSE(pad.tracker.at_rest(kIdentity, true));
}

TEST_CASE("With a fitted registration a pad moves from where it was seen at rest") {
  OnePad pad(true);
  // The registration is off by 0.4 mm: within what markers placed to 0.5 mm allow.
  const core::RigidTransform t{turn(90, Vec3::UnitZ()), Vec3(0.4, 0, 0)};
  const Vec3 seen = t.rotation.transpose() * kCenter;
  for (const double noise : {0.02, -0.02}) {
    pad.tracker.see_pose(0, seen + Vec3(noise, 0, 0), Mat3::Identity());
    REQUIRE(pad.tracker.at_rest(t, true));
    pad.tracker.learn_rest(50);
    pad.finish(0.01, true, t);
  }
  pad.tracker.see_pose(0, seen + Vec3(0.1, 0, 0), Mat3::Identity());
  CHECK(pad.tracker.at_rest(t, true));
  pad.tracker.see_pose(0, seen + Vec3(3, 0, 0), Mat3::Identity());
  CHECK_FALSE(pad.tracker.at_rest(t, true));
  CHECK(pad.finish(0.01, true, t).center.isApprox(kCenter + Vec3(0, 3, 0), 1e-12));
}

TEST_CASE("Turns are told from the orientation at rest, whatever the tracker's axes of the pad are") {
  OnePad pad;
  const Mat3 mounted = turn(170, Vec3(1, 2, -1));
  for (int frame = 0; frame < 3; ++frame) {
    pad.tracker.see_pose(0, kCenter, turn(frame - 1, Vec3::UnitZ()) * mounted);
    pad.tracker.learn_rest(50);
    pad.finish();
  }
  pad.tracker.see_pose(0, kCenter, turn(15, Vec3::UnitY()) * mounted);
  CHECK(pad.finish().rotation.isApprox(turn(15, Vec3::UnitY()), 1e-6));
}

TEST_CASE("Rest lasts until a pad moves, and comes back a second after it has returned") {
  RestGate gate;
  for (int frame = 0; frame < 5; ++frame) CHECK(gate.admits(true, 0.01));
  CHECK_FALSE(gate.admits(false, 0.01));
  int waited = 0;
  while (!gate.admits(true, 0.01)) ++waited;
  CHECK(waited == Approx(100).margin(1));
  CHECK(gate.admits(true, 0.01));
  CHECK_FALSE(gate.admits(false, 0.01));
  CHECK_FALSE(gate.admits(true, 0.5));
  CHECK_FALSE(gate.admits(false, 0.01));
  CHECK_FALSE(gate.admits(true, 0.5));  // it starts over
}
