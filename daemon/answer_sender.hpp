#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/daemon_config.hpp"
#include "core/scene.hpp"
#include "daemon/counters.hpp"
#include "daemon/duration_histogram.hpp"
#include "daemon/latency_window.hpp"
#include "daemon/message_sender.hpp"
#include "daemon/peer_table.hpp"
#include "daemon/rate_meter.hpp"
#include "daemon/simulation_thread.hpp"
#include "protocol/status_messages.hpp"

namespace tissued::daemon {

/// Sends the newest answer as predictions, as views of probes and as status, and measures how long answers took.
class AnswerSender {
 public:
  /// References must outlive this. tracker_rate_hz: of the frames received.
  AnswerSender(const config::DaemonConfig& config, const core::Scene& scene, const SimulationThread& simulation,
               const PeerTable& peers, MessageSender& sender, const Counters& counters,
               std::function<double()> tracker_rate_hz);

  void apply(const config::StalenessConfig& staleness) { staleness_ = staleness; }

  /// fresh: the answer has just been published, and its way through the daemon ends here.
  void send_predictions(Peer& peer, std::uint32_t in_reply_to, bool fresh);
  void send_probe_views(Peer& peer, std::uint32_t in_reply_to);
  void send_status(Peer& peer, std::uint32_t in_reply_to);

  /// A new answer was fetched.
  void note_step(std::uint64_t now_ns);
  /// The answer is older than answers may be.
  bool is_stale(std::uint64_t now_ns) const;

  const LatencyWindow& latency() const { return latency_; }
  const LatencyWindow& step_time() const { return step_time_; }
  /// How the daemon is doing, without the counters.
  protocol::Status status(std::uint64_t now_ns) const;
  std::string metrics() const;

 private:
  config::StalenessConfig staleness_;
  const SimulationThread& simulation_;
  const PeerTable& peers_;
  MessageSender& sender_;
  const Counters& counters_;
  std::function<double()> tracker_rate_hz_;
  std::vector<std::optional<core::ImagePlane>> images_;  // (probes)
  LatencyWindow latency_;                                // ns, from receiving a frame to sending its predictions
  LatencyWindow step_time_;                              // ns
  DurationHistogram latencies_, step_times_;             // since the start
  RateMeter step_rate_;
  std::uint64_t started_ns_;
};

}  // namespace tissued::daemon
