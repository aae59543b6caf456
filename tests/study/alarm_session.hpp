// Sessions of a live tissued, as fast as they go: a body that is not quite the assumed one, pushed over and over, seen
// by a tracker with noise and gaps, stepped through the stages of the daemon.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnosis/recorder.hpp"
#include "daemon/frame_processor.hpp"
#include "tests/study/pushes.hpp"

namespace tissued::study {

struct WatchedBody {
  std::string shape;
  core::Scene scene;  // as assumed
  core::Scene truth;  // its mesh twice as fine, its numbers slightly others
  std::vector<Push> pushes;
};

// E within 5 % and Poisson's ratio within 0.01 of what is assumed, markers placed to 0.3 to 0.5 mm. Draws again where
// there is no room for a pad.
WatchedBody draw_body(Random& random);

// What a tracker does to what it sees.
struct Nuisance {
  double noise = 0.1;         // mm per axis
  double blink = 0.01;        // chance that a marker is not seen in a frame
  double occlusions = 0.05;   // a second: a marker is gone for 0.2 to 3 s
  double gaps = 1.0 / 60.0;   // a second: no frame for 0.1 to 2 s
  double loud = 1.0 / 120.0;  // a second: noise is four times as large for 2 s
  double outliers = 0.05;     // a second: a marker is 20 mm off in a frame
};

// When an alarm is raised or has gone on for an hour, all is over.
struct AlarmRun {
  double seconds = 0.0;  // played
  int raised = 0;        // how often
  double raised_seconds = 0.0;
  double first_raised = -1.0;       // s; -1: never
  std::optional<core::Vec3> place;  // mm, tissue, when first raised
  double highest_level = 0.0;
  std::vector<double> evidences, ratios, misfits, loads,
      elements;  // of every draw: see core::MismatchAlarm; the misfit in mm
};

// A daemon without sockets.
class WatchedSession {
 public:
  WatchedSession(const core::Scene& scene, const Nuisance& nuisance, std::uint64_t seed);

  // One frame later. displaced: channels as RecordedTrial::seen, without noise; place_errors are in truth_markers.
  void step(const std::vector<core::PadInput>& pads, const Eigen::RowVectorXd& displaced,
            const std::vector<core::Vec3>& marker_rest);
  const AlarmRun& run() const { return run_; }
  double time() const { return frames_ / rate_; }
  const core::MismatchReport& report() const { return answer_.report.mismatch; }

 private:
  void begin_disturbances();
  bool is_lost(std::size_t marker);
  void note();

  Nuisance nuisance_;
  Random random_;
  double rate_;
  daemon::Counters counters_;
  std::unique_ptr<core::Simulator> simulator_;
  std::unique_ptr<daemon::FrameProcessor> processor_;
  protocol::TrackerFrame frame_;
  daemon::Answer answer_;
  AlarmRun run_;
  long draws_ = 0;
  double frames_ = 0;
  std::vector<double> hidden_until_;  // (markers) s
  double gap_until_ = 0.0, loud_until_ = 0.0;
};

// A null: random pushes for so many seconds.
AlarmRun play_null(const WatchedBody& body, const std::vector<PushCurve>& curves, double seconds, std::uint64_t seed);
// The truth's answers to the body's pushes; nothing where one has none.
std::optional<std::vector<PushCurve>> solve_pushes(const WatchedBody& body);

// Something is missing from the assumed physics, or wrong with the measurement.
struct Twin {
  std::vector<core::EffectSetting> effects;
  core::MeasurementFaults faults;
};
// Pushes one after the other for about so many seconds, solved along their way by quadratic elements of the scene's own
// mesh. first_push: s. Nothing where there is no equilibrium.
struct TwinRun {
  AlarmRun alarm;
  double first_push = 0.0;
  double misfit = 0.0;  // mm, RMS per axis, highest of the session
};
std::optional<TwinRun> play_twin(const WatchedBody& body, const Twin& twin, double seconds, std::uint64_t seed);

}  // namespace tissued::study
