// What a dynamic bundle becomes: the real beam's recordings, whose figures its README states.
#include "daemon/session_loader.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/diagnosis/seen_motion.hpp"

using namespace tissued;

TEST_CASE("recordings of a beam that is let go become displacements from where it was held", "[daemon]") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "real/beam";
  if (!std::filesystem::exists(folder)) {
    WARN(folder.string() + " is not here: skipped");
    return;
  }
  const core::RecordedSession session = daemon::load_session(config::load_bundle(folder));
  REQUIRE(session.trials.size() == 2);
  CHECK(session.is_dynamic());
  std::size_t tip = 0;
  while (session.scene.markers[tip].name != "Tip - 2") ++tip;
  const auto down = static_cast<Eigen::Index>(3 * tip + 2);
  const core::RecordedTrial &gravity = session.trials[0], &load = session.trials[1];
  CHECK(gravity.frame_count() == 500);
  CHECK(load.frame_count() == 600);
  CHECK(gravity.motion->release == Approx(0.66));
  CHECK(gravity.motion->held_undeformed);
  CHECK(gravity.motion->loads.empty());
  REQUIRE(load.motion->loads.size() == 1);
  CHECK(load.motion->loads[0].force.z() == Approx(-0.51012));
  CHECK(gravity.seen.col(down).minCoeff() == Approx(-10.65).margin(0.1));
  CHECK(gravity.seen(499, down) == Approx(-6.59).margin(0.1));
  CHECK(load.seen.col(down).minCoeff() == Approx(-24.98).margin(0.2));
  CHECK(load.seen(599, down) == Approx(-17.32).margin(0.1));
  CHECK(std::abs(gravity.seen(50, down)) < 0.05);
  CHECK(core::period_of(gravity) == Approx(1.0 / 7.73).epsilon(0.1));
  CHECK(core::period_of(load) == Approx(1.0 / 4.35).epsilon(0.1));
}
