#include "daemon/answer_sender.hpp"

#include <utility>

#include "daemon/answer_messages.hpp"
#include "daemon/metrics_text.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/validity.hpp"

namespace tissued::daemon {

AnswerSender::AnswerSender(const config::DaemonConfig& config, const core::Scene& scene,
                           const SimulationThread& simulation, const PeerTable& peers, MessageSender& sender,
                           const Counters& counters, std::function<double()> tracker_rate_hz)
    : staleness_(config.staleness),
      simulation_(simulation),
      peers_(peers),
      sender_(sender),
      counters_(counters),
      tracker_rate_hz_(std::move(tracker_rate_hz)),
      images_(config.bundle.probe_images),
      started_ns_(monotonic_ns()) {
  images_.resize(scene.probes.size());
}

void AnswerSender::send_predictions(Peer& peer, std::uint32_t in_reply_to, bool fresh) {
  const Answer& answer = simulation_.answer();
  const std::uint64_t send_ns = monotonic_ns();
  const Verdict verdict = judge(answer, send_ns, staleness_);
  const std::size_t parts = prediction_part_count(answer);
  for (std::size_t part = 0; part < parts; ++part) {
    sender_.send(peer, in_reply_to, prediction_part(answer, verdict, send_ns, part));
  }
  const bool held = !answer.has_frame || (answer.reasons & protocol::kDiverged) != 0;
  if (!fresh || held) return;
  const std::uint64_t latency_ns = monotonic_ns() - answer.receive_ns;
  latency_.add(latency_ns);
  latencies_.add(latency_ns);
}

void AnswerSender::send_probe_views(Peer& peer, std::uint32_t in_reply_to) {
  const Answer& answer = simulation_.answer();
  const std::uint64_t send_ns = monotonic_ns();
  const Verdict verdict = judge(answer, send_ns, staleness_);
  for (std::size_t probe = 0; probe < answer.probes.size(); ++probe) {
    const std::size_t parts = probe_view_part_count(answer, probe);
    for (std::size_t part = 0; part < parts; ++part) {
      sender_.send(peer, in_reply_to, probe_view_part(answer, images_[probe], verdict, send_ns, probe, part));
    }
  }
}

protocol::Status AnswerSender::status(std::uint64_t now_ns) const {
  const Verdict verdict = judge(simulation_.answer(), now_ns, staleness_);
  protocol::Status status;
  status.validity = verdict.validity;
  status.reasons = verdict.reasons;
  status.subscribers = static_cast<std::uint16_t>(peers_.subscriber_count());
  status.uptime_ns = now_ns - started_ns_;
  status.send_ns = now_ns;
  status.latency_p50_ns = latency_.percentile_ns(0.5);
  status.latency_p99_ns = latency_.percentile_ns(0.99);
  status.latency_max_ns = latency_.max_ns();
  status.step_p50_ns = step_time_.percentile_ns(0.5);
  status.step_p99_ns = step_time_.percentile_ns(0.99);
  status.step_max_ns = step_time_.max_ns();
  status.tracker_rate_hz = tracker_rate_hz_();
  status.step_rate_hz = step_rate_.rate_hz(now_ns);
  status.alarm = alarm_state(simulation_.answer().alarm);
  return status;
}

std::string AnswerSender::metrics() const {
  const protocol::Status now = status(monotonic_ns());
  return metrics_text({now, simulation_.answer(), counters_, latencies_, step_times_});
}

void AnswerSender::send_status(Peer& peer, std::uint32_t in_reply_to) {
  protocol::Status status = this->status(monotonic_ns());
  for (std::size_t part = 0; part < status_part_count(); ++part) {
    fill_status_counters(status, counters_, part);
    sender_.send(peer, in_reply_to, status);
  }
}

void AnswerSender::note_step(std::uint64_t now_ns) {
  const Answer& answer = simulation_.answer();
  if (!answer.has_frame) return;
  step_time_.add(answer.step_time_ns);
  step_times_.add(answer.step_time_ns);
  step_rate_.note(now_ns);
}

bool AnswerSender::is_stale(std::uint64_t now_ns) const {
  const Answer& answer = simulation_.answer();
  return !answer.has_frame || now_ns > answer.receive_ns + static_cast<std::uint64_t>(staleness_.stale_after.count());
}

}  // namespace tissued::daemon
