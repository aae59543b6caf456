// What goes wrong with markers in an operating room, done to a recorded trial: half a second after it ends, the targets
// are where they would have been without it.
#include <catch2/catch.hpp>
#include <deque>
#include <filesystem>
#include <functional>
#include <random>

#include "config/bundle.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/daemon/trial_replay.hpp"

namespace {

using namespace tissued;
using namespace tissued::daemon::testing;
namespace fs = std::filesystem;

const fs::path kBundle = fs::path(TISSUED_SHARED_DATA) / "recordings/paper/table1";
constexpr std::size_t kBegin = 60;  // frame; the pads are on their way in

struct Disturbance {
  const char* name;
  std::size_t frames;
  std::function<void(core::Observation&, std::size_t frame)> apply;
};

// Markers as they were `frames` ago; pads as they are.
class Late {
 public:
  explicit Late(std::size_t frames) : frames_(frames) {}
  void operator()(core::Observation& observation, std::size_t) {
    past_.push_back(observation.markers);
    if (past_.size() > frames_) past_.pop_front();
    observation.markers = past_.front();
  }

 private:
  std::size_t frames_;
  std::deque<std::vector<core::Vec3>> past_;
};

std::vector<Disturbance> disturbances() {
  const auto hide = [](std::size_t every) {
    return [every](core::Observation& observation, std::size_t) {
      for (std::size_t i = 0; i < observation.marker_seen.size(); i += every) observation.marker_seen[i] = 0;
    };
  };
  const auto outliers = [generator = std::mt19937(3)](core::Observation& observation, std::size_t) mutable {
    for (core::Vec3& marker : observation.markers)
      if (generator() % 20 == 0) marker += core::Vec3(20.0, -15.0, 10.0);
  };
  const auto swap = [](core::Observation& observation, std::size_t) {
    std::swap(observation.markers[2], observation.markers[9]);
  };
  return {{"nothing", 0, [](core::Observation&, std::size_t) {}},
          {"half of the markers gone for 2 s", 200, hide(2)},
          {"all markers gone for 1 s", 100, hide(1)},
          {"one marker in twenty 27 mm off for 2 s", 200, outliers},
          {"two labels swapped for 2 s", 200, swap},
          {"markers 80 ms late for 2 s", 200, Late(8)}};
}

// mm; how far markers eight frames late, that do or do not say so, take the targets from where markers on time have
// them: mean over targets and the frames from kBegin to `end`, the pads on their way in.
double astray_while_late(const core::Scene& scene, const protocol::Trial& trial, bool say_so, std::size_t end) {
  const auto simulator = core::make_simulator(scene, core::SimulatorOptions{}),
             on_time = core::make_simulator(scene, core::SimulatorOptions{});
  TrialReplay replay(scene, trial);
  Late late(8);
  double sum = 0.0;
  for (std::size_t f = 0; f < end; ++f) {
    core::Observation observation = replay.frame(f);
    on_time->step(observation);
    late(observation, f);
    if (say_so) observation.marker_age = 0.01 * static_cast<double>(std::min<std::size_t>(f, 8));
    const core::StepReport report = simulator->step(observation);
    CHECK(report.markers_too_late == 0);
    if (f < kBegin) continue;
    for (int t = 0; t < static_cast<int>(scene.targets.size()); ++t)
      sum += (simulator->target(t).position - on_time->target(t).position).norm();
  }
  return sum / static_cast<double>((end - kBegin) * scene.targets.size());
}

// mm; of the mean over a fifth of a second, half a second after the disturbance would end, over the targets.
double error_after(const core::Scene& scene, const protocol::Trial& trial, const Disturbance& disturbance,
                   std::size_t end) {
  const auto simulator = core::make_simulator(scene, core::SimulatorOptions{});
  TrialReplay replay(scene, trial);
  std::vector<core::Vec3> difference(scene.targets.size(), core::Vec3::Zero());
  for (std::size_t f = 0; f < end + 70; ++f) {
    core::Observation observation = replay.frame(f);
    if (f >= kBegin && f < kBegin + disturbance.frames) disturbance.apply(observation, f);
    simulator->step(observation);
    if (f < end + 50) continue;
    for (std::size_t t = 0; t < scene.targets.size(); ++t)
      difference[t] += (simulator->target(static_cast<int>(t)).position -
                        at(trial, f, trial.find_label(scene.targets[t].name).value())) /
                       20.0;
  }
  double sum = 0.0;
  for (const core::Vec3& d : difference) sum += d.norm();
  return sum / static_cast<double>(difference.size());
}

}  // namespace

TEST_CASE("half a second after a disturbance the targets are where they would have been") {
  if (!fs::exists(kBundle)) {
    WARN("skipped: no recordings in " << kBundle);
    return;
  }
  const core::Scene scene = daemon::load_scene(config::load_bundle(kBundle));
  const std::string name = GENERATE("exp03", "exp10", "exp15");
  const protocol::Trial trial = protocol::read_nexus_csv(kBundle / (name + ".csv"));
  const auto all = disturbances();
  for (std::size_t k = 1; k < all.size(); ++k) {
    const std::size_t end = kBegin + all[k].frames;
    const double undisturbed = error_after(scene, trial, all[0], end),
                 disturbed = error_after(scene, trial, all[k], end);
    INFO(name << ", " << all[k].name << ": " << disturbed << " mm, undisturbed " << undisturbed << " mm");
    CHECK(disturbed < 2.0 * undisturbed);
  }
}

TEST_CASE("late markers that say how late they are correct the state of their time") {
  if (!fs::exists(kBundle)) {
    WARN("skipped: no recordings in " << kBundle);
    return;
  }
  const core::Scene scene = daemon::load_scene(config::load_bundle(kBundle));
  const protocol::Trial trial = protocol::read_nexus_csv(kBundle / "exp12.csv");
  constexpr std::size_t kEnd = 100;
  const double silent = astray_while_late(scene, trial, false, kEnd),
               said = astray_while_late(scene, trial, true, kEnd);
  INFO("80 ms late, mm astray: " << silent << " where nobody says so, " << said << " where the markers do");
  CHECK(said < 0.5 * silent);
}

TEST_CASE("markers that are later than the simulation remembers are not used") {
  if (!fs::exists(kBundle)) {
    WARN("skipped: no recordings in " << kBundle);
    return;
  }
  const core::Scene scene = daemon::load_scene(config::load_bundle(kBundle));
  const protocol::Trial trial = protocol::read_nexus_csv(kBundle / "exp03.csv");
  const auto simulator = core::make_simulator(scene, core::SimulatorOptions{});
  TrialReplay replay(scene, trial);
  for (std::size_t f = 0; f < 90; ++f) {
    core::Observation observation = replay.frame(f);
    observation.marker_age = f < 70 ? 0.0 : 0.7;
    const core::StepReport report = simulator->step(observation);
    CHECK(report.markers_used == (f < 70 ? 19 : 0));
    CHECK(report.markers_too_late == (f < 70 ? 0 : 19));
  }
}
