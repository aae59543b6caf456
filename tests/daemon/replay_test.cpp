// A recorded trial through the simulators: the same bits whatever the number of threads, and the filter earns its keep.
#include <catch2/catch.hpp>
#include <filesystem>

#include "config/bundle.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/daemon/trial_replay.hpp"

namespace {

using namespace tissued;
using namespace tissued::daemon::testing;
namespace fs = std::filesystem;

const fs::path kBundle = fs::path(TISSUED_SHARED_DATA) / "recordings/paper/table1";

std::vector<std::uint64_t> hashes(const core::Scene& scene, const protocol::Trial& trial,
                                  core::SimulatorOptions options, int threads) {
  options.solver.threads = threads;
  const auto simulator = core::make_simulator(scene, options);
  TrialReplay replay(scene, trial);
  std::vector<std::uint64_t> all;
  for (std::size_t f = 0; f < trial.frame_count; f += 2) {
    simulator->step(replay.frame(f));
    all.push_back(simulator->state_hash());
  }
  return all;
}

// mm, error of the mean over the hold (frames 150 to 250 of table1's trials), averaged over the targets.
double hold_error(const core::Scene& scene, const protocol::Trial& trial, const core::SimulatorOptions& options) {
  const auto simulator = core::make_simulator(scene, options);
  TrialReplay replay(scene, trial);
  std::vector<core::Vec3> difference(scene.targets.size(), core::Vec3::Zero());
  for (std::size_t f = 0; f < 250; ++f) {
    simulator->step(replay.frame(f));
    if (f < 150) continue;
    for (std::size_t t = 0; t < scene.targets.size(); ++t)
      difference[t] += (simulator->target(static_cast<int>(t)).position -
                        at(trial, f, trial.find_label(scene.targets[t].name).value())) /
                       100.0;
  }
  double sum = 0.0;
  for (const core::Vec3& d : difference) sum += d.norm();
  return sum / static_cast<double>(difference.size());
}

}  // namespace

TEST_CASE("a replay gives the same bits, run twice, on one thread and on two") {
  if (!fs::exists(kBundle)) {
    WARN("skipped: no recordings in " << kBundle);
    return;
  }
  const core::Scene scene = daemon::load_scene(config::load_bundle(kBundle));
  const protocol::Trial trial = protocol::read_nexus_csv(kBundle / "exp12.csv");
  core::SimulatorOptions options;
  options.kind = GENERATE("admm", "kf-admm");
  const auto once = hashes(scene, trial, options, 1);
  CHECK(once == hashes(scene, trial, options, 1));
  CHECK(once == hashes(scene, trial, options, 2));
  CHECK(once.front() != once.back());
}

TEST_CASE("the filter brings concealed targets nearer, by both presets") {
  if (!fs::exists(kBundle)) {
    WARN("skipped: no recordings in " << kBundle);
    return;
  }
  const core::Scene scene = daemon::load_scene(config::load_bundle(kBundle));
  const protocol::Trial trial = protocol::read_nexus_csv(kBundle / "exp03.csv");
  core::SimulatorOptions open;
  open.kind = "admm";
  CHECK(hold_error(scene, trial, core::SimulatorOptions{}) < hold_error(scene, trial, open));
  core::SimulatorOptions paper;
  paper.solver.element = core::Element::p1;
  paper.solver.weight_scale = 4.0;
  paper.solver.scheme = core::Scheme::algorithm_1;
  paper.filter.preset = core::NoisePreset::paper;
  core::SimulatorOptions paper_open = paper;
  paper_open.kind = "admm";
  CHECK(hold_error(scene, trial, paper) < 0.6 * hold_error(scene, trial, paper_open));
}
