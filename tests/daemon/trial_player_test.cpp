#include "daemon/trial_player.hpp"

#include <catch2/catch.hpp>
#include <csignal>

#include "daemon/monotonic_clock.hpp"
#include "daemon/play_report.hpp"
#include "tests/daemon/fake_daemon.hpp"
#include "tests/daemon/recording_samples.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

const config::Bundle bundle = sample_bundle();

// Plays the sample recording to a fake daemon, as often as asked.
struct Session {
  explicit Session(FakeDaemonScript script, const PlayOptions& options = {})
      : daemon(std::move(script)),
        recording(bundle, bundle.trials.front(), sample_trial()),
        sender(daemon.tracker()),
        client(daemon.clients()),
        subscription(client, protocol::kTargets, 0.0),
        player(sender, &subscription, options, stop) {
    client.subscribe({});
  }
  std::vector<TargetError> errors(const PlayedTrial& played) {
    return target_errors(bundle, recording, played, {"T1", "T2"});
  }

  FakeDaemon daemon;
  Recording recording;
  TrackerSender sender;
  PredictionClient client;
  Subscription subscription;
  StopSignal stop;
  TrialPlayer player;
};

}  // namespace

TEST_CASE("Every frame is sent, answered and compared with its own truth") {
  Session session({});
  const PlayedTrial played = session.player.play(session.recording);
  CHECK(played.sent == 60);
  CHECK(played.answered == 60);
  const auto errors = session.errors(played);
  REQUIRE(errors.size() == 2);
  CHECK(errors[0].hold_mm == Approx(0.5));  // the fake's offset of (0.3, 0, 0.4) mm
  CHECK(errors[0].rms_mm == Approx(0.5));
  CHECK(errors[0].frames == 60);
  CHECK(std::isnan(errors[1].hold_mm));  // T2 was not seen in the hold
  CHECK(errors[1].rms_mm == Approx(0.5));
  CHECK(errors[1].frames == 40);

  const auto frames = session.daemon.frames();
  REQUIRE(frames.size() == 60);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CHECK(frames[i].frame_number == i + 1);
    CHECK(frames[i].stamp_ns.value() - frames[0].stamp_ns.value() == i * 5'000'000);
    CHECK(frames[i].markers.size() == 3);
  }
}

TEST_CASE("Frames leave at their deadlines") {
  for (const double speed : {1.0, 4.0}) {
    PlayOptions options;
    options.speed = speed;
    Session session({}, options);
    session.player.play(session.recording);
    const auto frames = session.daemon.frames();
    REQUIRE(frames.size() == 60);
    const double took = double(frames.back().receive_ns - frames.front().receive_ns) * 1e-9;
    CHECK(took == Approx(59.0 / 200.0 / speed).margin(0.03));
    // The tracker's clock keeps the recorded pace.
    CHECK(frames.back().stamp_ns.value() - frames.front().stamp_ns.value() == 59 * 5'000'000);
  }
}

TEST_CASE("Answers that do not come are counted as lost, not guessed") {
  FakeDaemonScript script;
  script.answers = [](std::uint64_t frame) { return frame % 10 != 4; };
  Session session(script);
  const PlayedTrial played = session.player.play(session.recording);
  CHECK(played.sent == 60);
  CHECK(played.answered == 54);
  CHECK(played.find_answer(4) == nullptr);
  REQUIRE(played.find_answer(5) != nullptr);
  CHECK(played.find_answer(5)->answer.frame.tracker_frame == 6);
  CHECK(session.errors(played)[0].hold_mm == Approx(0.5));
}

TEST_CASE("A second trial begins with frame 1 after a pause, and its clock runs on") {
  PlayOptions options;
  options.speed = 4.0;
  options.pause = 0.55;  // longer than an assembler's silence for restarts
  Session session({}, options);
  CHECK(session.player.play(session.recording).answered == 60);
  CHECK(session.player.play(session.recording).answered == 60);
  const auto frames = session.daemon.frames();
  REQUIRE(frames.size() == 120);
  CHECK(frames[60].frame_number == 1);
  CHECK(frames[60].after_restart);
  CHECK(frames[60].stamp_ns.value() > frames[59].stamp_ns.value());
  CHECK(double(frames[60].receive_ns - frames[59].receive_ns) * 1e-9 >= 0.54);
}

TEST_CASE("The lead-in repeats the opening rest and is not compared") {
  PlayOptions options;
  options.speed = 4.0;
  options.lead_in = 0.125;  // 25 frames at 200 Hz
  Session session({}, options);
  const PlayedTrial played = session.player.play(session.recording);
  CHECK(played.sent == 85);
  CHECK(played.answered == 85);
  const auto frames = session.daemon.frames();
  REQUIRE(frames.size() == 85);
  CHECK(frames[0].frame_number == 1);
  for (std::size_t i = 0; i < 25; ++i) CHECK(frames[i].objects[0].position == std::array<double, 3>{50, 0, 0});
  CHECK(frames[13].markers[1].occluded);  // frame 3 of ten, the second time round
  CHECK(session.errors(played)[0].frames == 60);
}

TEST_CASE("Playing stops when its time is up") {
  PlayOptions options;
  options.stop_after = 0.1;
  Session session({}, options);
  CHECK(session.player.play(session.recording).sent == 20);
  CHECK(session.player.finished());
}

TEST_CASE("A stop ends a trial early") {
  Session session({});
  std::thread([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(80));
    std::raise(SIGTERM);
  }).detach();
  const PlayedTrial played = session.player.play(session.recording);
  CHECK(played.sent < 60);
  CHECK(session.player.finished());
}

TEST_CASE("Predictions are written as a recording with gaps where none came") {
  FakeDaemonScript script;
  script.answers = [](std::uint64_t frame) { return frame != 7; };
  Session session(script);
  const PlayedTrial played = session.player.play(session.recording);
  const protocol::Trial trial = predictions_as_trial(bundle, session.recording, played, {"T1", "T2"}, {"A1"});
  CHECK(trial.first_frame == 101);
  CHECK(trial.frame_count == 60);
  CHECK(trial.rate_hz == 200);
  CHECK_FALSE(trial.is_seen(7, 0));
  REQUIRE(trial.is_seen(8, 0));
  CHECK(trial.position(8, 0)[0] == Approx(3.3));
  CHECK(trial.position(8, 0)[2] == Approx(30.4));
}

TEST_CASE("The report counts and averages") {
  FakeDaemonScript script;
  script.answers = [](std::uint64_t frame) { return frame != 7; };
  PlayOptions options;
  options.speed = 4.0;
  Session session(script, options);
  PlayReport report({"T1", "T2"});
  for (int i = 0; i < 2; ++i) {
    const PlayedTrial played = session.player.play(session.recording);
    report.add("push", played, session.errors(played));
  }
  const nlohmann::json json = report.json();
  CHECK(json["frames"] == 120);
  CHECK(json["lost"] == 1);
  CHECK(json["trials"].size() == 2);
  CHECK(json["trials"][0]["lost"] == 1);
  CHECK(json["trials"][1]["validity"]["valid"] == 60);
  CHECK(json["mean"]["targets"]["T1"]["hold_mm"].get<double>() == Approx(0.5));
  CHECK(json["mean"]["targets"]["T2"]["hold_mm"].is_null());
  CHECK(json["latency_ms"]["there_and_back"]["max"].get<double>() > 0.0);
  const std::string text = report.text(true);
  CHECK_THAT(text, Catch::Contains("push") && Catch::Contains("0.500") && Catch::Contains("receive to send"));
}
