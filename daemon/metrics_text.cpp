#include "daemon/metrics_text.hpp"

#include <unistd.h>

#include <cmath>
#include <fstream>
#include <string_view>

#include "daemon/version.hpp"
#include "protocol/prediction_messages.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::daemon {
namespace {

class MetricsWriter {
 public:
  void describe(std::string_view name, std::string_view type, std::string_view help) {
    text_.append("# HELP ").append(name).append(" ").append(help).append("\n");
    text_.append("# TYPE ").append(name).append(" ").append(type).append("\n");
  }
  // labels: `name="value"`, as they stand between braces; values are names of our own, with nothing to escape.
  void sample(std::string_view name, std::string_view labels, double value) {
    text_.append(name);
    if (!labels.empty()) text_.append("{").append(labels).append("}");
    text_.append(" ");
    if (std::isfinite(value)) {
      protocol::append_number(text_, value);
    } else {
      text_.append("NaN");
    }
    text_.append("\n");
  }
  void gauge(std::string_view name, std::string_view help, double value) {
    describe(name, "gauge", help);
    sample(name, {}, value);
  }
  void histogram(const std::string& name, std::string_view help, const DurationHistogram& durations) {
    describe(name, "histogram", help);
    std::uint64_t below = 0;
    for (std::size_t limit = 0; limit < DurationHistogram::kLimits.size(); ++limit) {
      below += durations.count(limit);
      std::string label = "le=\"";
      protocol::append_number(label, DurationHistogram::kLimits[limit]);
      sample(name + "_bucket", label + "\"", static_cast<double>(below));
    }
    below += durations.count(DurationHistogram::kLimits.size());
    sample(name + "_bucket", "le=\"+Inf\"", static_cast<double>(below));
    sample(name + "_sum", {}, durations.sum());
    sample(name + "_count", {}, static_cast<double>(below));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

double seconds(std::uint64_t ns) { return 1e-9 * static_cast<double>(ns); }

void write_validity(const protocol::Status& status, MetricsWriter& out) {
  using protocol::Validity;
  out.describe("tissued_validity", "gauge", "1 for what the newest answer is, 0 for what it is not.");
  for (const Validity validity : {Validity::no_data, Validity::valid, Validity::degraded, Validity::invalid})
    out.sample("tissued_validity", std::string("state=\"") + protocol::to_string(validity) + "\"",
               status.validity == validity ? 1.0 : 0.0);
  out.describe("tissued_reason", "gauge", "1 for every reason why the newest answer is not quite valid.");
  for (unsigned bit = 0; bit < protocol::kValidityReasonCount; ++bit)
    out.sample("tissued_reason", std::string("reason=\"") + protocol::validity_reason_name(bit) + "\"",
               (status.reasons >> bit) & 1U);
}

void write_answer(const Answer& answer, MetricsWriter& out) {
  out.gauge("tissued_markers_used", "Markers that the newest step used.", answer.report.markers_used);
  out.gauge("tissued_innovation_rms_mm", "Distance of markers from where they were expected, per axis, newest step.",
            answer.report.innovation_rms);
  out.gauge("tissued_iterations", "ADMM iterations of the newest step.", answer.report.iterations);
  out.gauge("tissued_overload_level",
            "How much is left out because steps take too long: 0 nothing, 3 iterations, 6 meshes.", answer.overload);
  out.gauge("tissued_alarm_watching", "1 once enough was seen to judge the assumed physics.", answer.alarm.watching);
  out.gauge("tissued_alarm_raised", "1 while markers contradict the assumed physics: a diagnosis is due.",
            answer.alarm.raised);
  out.gauge("tissued_alarm_level", "Evidence against the assumed physics, in units of what raises the alarm.",
            answer.alarm.level);
  out.gauge("tissued_alarm_misfit_mm", "What the assumed physics misses at the markers, RMS per axis.",
            answer.alarm.misfit);
}

void write_counters(const Counters& counters, MetricsWriter& out) {
  out.describe("tissued_events_total", "counter", "Everything that happened, was skipped or was refused, by reason.");
  for (std::size_t i = 0; i < Counters::kSize; ++i)
    out.sample("tissued_events_total", "event=\"" + Counters::name(i) + "\"", static_cast<double>(counters.value(i)));
}

// Bytes; the kernel counts in pages.
double resident_memory() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0, resident = NAN;
  statm >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

std::string metrics_text(const Metrics& metrics) {
  MetricsWriter out;
  out.describe("tissued_build_info", "gauge", "Which tissued this is.");
  out.sample("tissued_build_info", std::string("version=\"") + kVersion + "\"", 1.0);
  out.gauge("tissued_uptime_seconds", "Since the start.", seconds(metrics.status.uptime_ns));
  out.gauge("tissued_tracker_rate_hertz", "Tracker frames received in the last second.",
            metrics.status.tracker_rate_hz);
  out.gauge("tissued_step_rate_hertz", "Frames simulated in the last second.", metrics.status.step_rate_hz);
  out.gauge("tissued_subscribers", "Clients that are streamed to.", metrics.status.subscribers);
  write_validity(metrics.status, out);
  write_answer(metrics.answer, out);
  out.histogram("tissued_latency_seconds", "From receiving a tracker frame to sending its predictions.",
                metrics.latency);
  out.histogram("tissued_step_seconds", "Duration of simulation steps.", metrics.step);
  write_counters(metrics.counters, out);
  out.gauge("process_resident_memory_bytes", "Memory that is in use.", resident_memory());
  return out.take();
}

}  // namespace tissued::daemon
