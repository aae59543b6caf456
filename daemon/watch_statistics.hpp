#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/duration_sample.hpp"
#include "daemon/latency_window.hpp"
#include "daemon/target_answer.hpp"
#include "protocol/session_messages.hpp"

namespace tissued::daemon {

/// Errors of one target against the truth that is streamed with it, since watching began.
struct ErrorStatistics {
  std::size_t frames = 0;
  std::size_t inside = 0;  ///< frames whose truth lay in the 95 % ellipsoid
  std::size_t judged = 0;  ///< frames that claimed one
  double sum = 0.0;        ///< mm
  double most = 0.0;       ///< mm

  double mean() const { return frames == 0 ? 0.0 : sum / static_cast<double>(frames); }
};

struct WatchedTarget {
  std::string name;
  std::optional<protocol::TargetPrediction> latest;
  std::optional<double> error;  ///< mm, the newest one; gone a tick after the truth is
  ErrorStatistics errors;
  std::deque<double> trace;  ///< mm, largest error of each tick, newest last; NaN where there was none
};

/// What a watcher has seen: the newest answer and the running account. Pure bookkeeping: time is an argument.
class WatchStatistics {
 public:
  static constexpr std::uint64_t kTick_ns = 500'000'000;  // of WatchedTarget::trace
  static constexpr std::size_t kTraceLength = 120;        // ticks

  /// A daemon said who it is; its targets start anew if they are others than before.
  void introduce(const protocol::HelloReply& hello, const std::vector<std::string>& targets,
                 const std::vector<std::string>& pads);

  /// An answer of the stream: one per tracker frame.
  void add_streamed(const TargetAnswer& answer);
  /// An answer to a question: shows the state of things while the stream is silent, and counts for nothing.
  void add_asked(const TargetAnswer& answer) { show(answer); }
  /// Moves traces on. Call it often.
  void tick(std::uint64_t now_ns);

  const std::optional<protocol::HelloReply>& hello() const { return hello_; }
  const std::vector<WatchedTarget>& targets() const { return targets_; }
  const std::vector<std::string>& pad_names() const { return pad_names_; }
  const std::optional<TargetAnswer>& latest() const { return latest_; }

  /// Age of the tracker frame behind the latest answer, at `now_ns`.
  std::uint64_t age_ns(std::uint64_t now_ns) const;
  /// Answers per second over the last two seconds.
  double rate_hz(std::uint64_t now_ns) const;
  std::uint64_t frames() const { return frames_; }
  std::uint64_t lost() const { return lost_; }          ///< frame numbers that never brought an answer here
  std::uint64_t restarts() const { return restarts_; }  ///< times that frame numbers went back
  const std::map<protocol::Validity, std::uint64_t>& validity() const { return validity_; }

  /// Receive to send; empty where no frame came for two seconds.
  const LatencyWindow& recent_latency() const { return recent_latency_; }
  const LatencyWindow& recent_step() const { return recent_step_; }
  const DurationSample& latency() const { return latency_; }  ///< receive to send, since watching began
  const DurationSample& step() const { return step_; }

 private:
  void show(const TargetAnswer& answer);
  void count_frame(std::uint32_t frame);
  void judge(WatchedTarget& target, const protocol::TargetPrediction& prediction);

  std::optional<protocol::HelloReply> hello_;
  std::vector<WatchedTarget> targets_;
  std::vector<double> tick_errors_;  // (targets) mm, largest since the last tick; NaN: none yet
  std::vector<std::string> pad_names_;
  std::optional<TargetAnswer> latest_;
  std::deque<std::uint64_t> arrivals_;  // ns, of the last two seconds
  std::optional<std::uint32_t> last_frame_;
  std::uint64_t tick_ns_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t restarts_ = 0;
  std::map<protocol::Validity, std::uint64_t> validity_;
  LatencyWindow recent_latency_, recent_step_;
  DurationSample latency_, step_;
};

}  // namespace tissued::daemon
