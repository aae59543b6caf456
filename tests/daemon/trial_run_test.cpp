// Runs in process are what a daemon answers that loses no frame.
#include "daemon/trial_run.hpp"

#include <catch2/catch.hpp>
#include <thread>

#include "daemon/runtime.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/trial_player.hpp"
#include "tests/daemon/evaluation_bundle.hpp"
#include "tests/daemon/recording_samples.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

// The trial, played to a daemon fresh from its start; empty where the machine was too busy to answer every frame.
std::optional<PlayedTrial> play(const config::DaemonConfig& config, const core::Scene& scene,
                                const Recording& recording) {
  const auto simulator = core::make_simulator(scene, config.simulator);
  Runtime runtime(config, *simulator);
  std::thread serving([&] { runtime.run(); });
  PlayedTrial played;
  {
    TrackerSender sender({"127.0.0.1", runtime.tracker_port()});
    PredictionClient client({"127.0.0.1", runtime.client_port()});
    client.subscribe({.what = protocol::kTargets});
    Subscription subscription(client, protocol::kTargets, 0.0);
    const StopSignal stop;
    played = TrialPlayer(sender, &subscription, {}, stop).play(recording);
  }
  runtime.stop();
  serving.join();
  return played.answered == recording.frame_count() ? std::optional(played) : std::nullopt;
}

}  // namespace

TEST_CASE("A run gives to the bit what a daemon answers") {
  const TemporaryFolder folder;
  const auto path = write_evaluation_bundle(folder);
  const std::string kind = GENERATE("kf-admm", "admm");
  const config::DaemonConfig config =
      config::config_for_bundle(path, std::vector<std::string>{"simulator.kind=" + kind, "simulator.threads=1",
                                                               "markers=most", "tracker.port=0", "clients.port=0"});
  const core::Scene scene = load_scene(config.bundle);
  const config::Bundle bundle = config::load_bundle(path);
  const Recording recording(bundle, *bundle.find_trial("deep"), read_trial(path / "deep.csv"));

  std::optional<PlayedTrial> played;
  for (int attempt = 0; attempt < 5 && !played; ++attempt) played = play(config, scene, recording);
  REQUIRE(played);

  const TrialRun run = run_trial(config, scene, recording, recorded_order(recording));
  REQUIRE(run.size() == kCubeFrames);
  for (std::size_t i = 0; i < run.size(); ++i) {
    INFO("frame " << i);
    const protocol::TargetPrediction& answer = played->find_answer(i)->answer.targets.at(0);
    const core::Vec3& position = run[i].targets.at(0).position;
    CHECK(answer.position == std::array<double, 3>{position.x(), position.y(), position.z()});
    CHECK(answer.covariance == run[i].targets[0].covariance);
    CHECK(run[i].targets[0].measured.has_value() == (i != 45));
    CHECK(run[i].contact);
    CHECK_FALSE(run[i].diverged);
    CHECK(run[i].time == Approx(0.01 * static_cast<double>(i)));
  }
}

TEST_CASE("Pads jump from the opening rest into the hold") {
  const config::Bundle bundle = sample_bundle();
  const Recording recording(bundle, bundle.trials.front(), sample_trial());
  const auto order = jump_order(recording, 20);
  // Ten frames of rest; the hold is frames 33 to 49, then from its beginning again.
  REQUIRE(order.size() == 30);
  for (std::size_t i = 0; i < 10; ++i) CHECK(order[i] == i);
  for (std::size_t i = 0; i < 17; ++i) CHECK(order[10 + i] == 33 + i);
  CHECK(order[27] == 33);
  CHECK(order[29] == 35);
}

TEST_CASE("Where no pad moves none can jump") {
  const config::Bundle bundle = sample_bundle();
  protocol::Trial trial = sample_trial();
  for (std::size_t frame = 0; frame < trial.frame_count; ++frame) trial.positions[frame * 6 + 5] = {50, 0, 0};
  CHECK(jump_order(Recording(bundle, bundle.trials.front(), trial), 20).empty());
}
