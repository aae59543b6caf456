#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/monotonic_clock.hpp"
#include "daemon/recording.hpp"
#include "daemon/stop_signal.hpp"
#include "daemon/subscription.hpp"
#include "daemon/tracker_sender.hpp"

namespace tissued::daemon {

struct PlayOptions {
  double speed = 1.0;       ///< times as fast as recorded
  double lead_in = 0.0;     ///< s of the recording's opening rest, repeated, before it
  double pause = 0.6;       ///< s of silence between two trials
  double stop_after = 0.0;  ///< s of streaming in all trials together; 0: to the end of the last one
  RecordingItems items;
};

/// What the daemon said to one frame.
struct FrameAnswer {
  TargetAnswer answer;
  std::uint64_t round_trip_ns = 0;  ///< from our sending the frame to our having the answer
};

struct PlayedTrial {
  std::size_t lead_in = 0;                          ///< frames that came before the recording
  std::size_t sent = 0;                             ///< frames, those of the lead-in among them
  std::size_t answered = 0;                         ///< of those sent
  std::vector<std::optional<FrameAnswer>> answers;  ///< (lead_in + frames of the recording)

  /// nullptr where frame `index` of the recording was not answered.
  const FrameAnswer* find_answer(std::size_t index) const {
    const auto& slot = answers[lead_in + index];
    return slot ? &*slot : nullptr;
  }
};

/// Streams recordings as a tracker would and collects what the daemon says to every frame. One thread of its own sends
/// at absolute deadlines while the caller's receives.
///
/// Frame numbers begin at 1 with every trial, as after a restart of the tracker; its clock, in the stamps, runs on at
/// the recorded pace, however fast the frames are sent. By the stamp an answer is known to belong to its frame.
class TrialPlayer {
 public:
  /// `answers` may be nullptr: then nothing is asked. All must outlive the player.
  TrialPlayer(TrackerSender& sender, Subscription* answers, const PlayOptions& options, const StopSignal& stop)
      : sender_(sender), answers_(answers), options_(options), stop_(stop), tracker_clock_ns_(monotonic_ns()) {}

  /// Returns when the last frame is answered, or 0.3 s after it was sent, or soon after a stop was requested. Throws
  /// std::runtime_error where a frame does not fit the wire.
  PlayedTrial play(const Recording& recording);

  /// Nothing is to be played any more: options.stop_after is over or a stop was requested.
  bool finished() const;

 private:
  struct Schedule {
    std::size_t lead_in;           // frames
    std::size_t total;             // frames, lead_in among them
    std::uint64_t start_ns;        // monotonic clock, frame 0
    std::uint64_t first_stamp_ns;  // tracker's clock, frame 0
    double rate_hz;                // of the recording
    double speed;                  // times as fast
    std::uint64_t send_ns(std::size_t frame) const;
    std::uint64_t stamp_ns(std::size_t frame) const;
    std::optional<std::size_t> frame_of(std::uint64_t stamp_ns) const;
  };
  struct Progress;

  Schedule schedule_for(const Recording& recording) const;
  void send_all(const Recording& recording, const Schedule& schedule, Progress& progress);
  void receive_all(const Schedule& schedule, Progress& progress, PlayedTrial& played);
  void take(const TargetAnswer& answer, const Schedule& schedule, const Progress& progress, PlayedTrial& played);

  TrackerSender& sender_;
  Subscription* answers_;
  PlayOptions options_;
  const StopSignal& stop_;
  std::uint64_t tracker_clock_ns_;  // begins at the machine's: no answer to another run can be taken for one to this
  std::uint64_t earliest_start_ns_ = 0;
  double streamed_ = 0.0;  // s, wall clock, of all trials so far
};

}  // namespace tissued::daemon
