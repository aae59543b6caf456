#include "daemon/watch_report.hpp"

#include <cmath>

#include "daemon/alarm_report.hpp"
#include "daemon/confidence.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

using nlohmann::json;

double ms(std::uint64_t ns) { return static_cast<double>(ns) * 1e-6; }

DurationPercentiles percentiles_ms(const DurationSample& sample) {
  return {sample.percentile_ms(0.5), sample.percentile_ms(0.99), sample.max_ms()};
}

std::string percentiles(const DurationPercentiles& ms) {
  return "p50 " + fixed(ms.p50, 2) + "  p99 " + fixed(ms.p99, 2) + "  max " + fixed(ms.max, 2) + " ms";
}

json percentiles_json(const DurationPercentiles& ms) { return {{"p50", ms.p50}, {"p99", ms.p99}, {"max", ms.max}}; }

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? NAN : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::string age_text(std::uint64_t age_ns) {
  if (age_ns < 1'000'000'000) return fixed(ms(age_ns), 0) + " ms old";
  return fixed(static_cast<double>(age_ns) * 1e-9, 1) + " s old";
}

DurationPercentiles percentiles_ms(const LatencyWindow& window) {
  if (window.size() == 0) return {NAN, NAN, NAN};
  return {ms(window.percentile_ns(0.5)), ms(window.percentile_ns(0.99)), ms(window.max_ns())};
}

std::string watch_line(const WatchStatistics& statistics, const Connection& connection, double elapsed,
                       std::uint64_t now_ns) {
  std::string line = pad_to(fixed(elapsed, 1) + " s", 8, true);
  if (!connection.answering) {
    return line + "  no answer from " + connection.address + "; asking on";
  }
  if (!statistics.latest()) return line + "  connected to " + connection.address;
  const protocol::Predictions& frame = statistics.latest()->frame;
  const DurationPercentiles latency = percentiles_ms(statistics.recent_latency());
  line += std::string("  ") + protocol::to_string(frame.validity);
  for (const std::string& reason : reason_names(frame.reasons)) line += ' ' + reason;
  line += "  frame " + std::to_string(frame.tracker_frame) + ", " + age_text(statistics.age_ns(now_ns)) + "  " +
          fixed(statistics.rate_hz(now_ns), 1) + " Hz, " + std::to_string(statistics.lost()) + " lost  p50 " +
          fixed(latency.p50, 2) + " p99 " + fixed(latency.p99, 2) + " max " + fixed(latency.max, 2) + " ms";
  if (frame.alarm.raised) line += "  ALARM " + alarm_text(frame.alarm);
  for (const WatchedTarget& target : statistics.targets()) {
    if (!target.latest) continue;
    const auto& error = target.error;
    const auto radius = radius_95(target.latest->covariance);
    if (error || radius) line += "  " + target.name;
    if (error) line += ' ' + fixed(*error, 2);
    if (radius) line += " +-" + fixed(*radius, 2);
  }
  return line;
}

json watch_json(const WatchStatistics& statistics, const Connection& connection, double elapsed, std::uint64_t now_ns) {
  json object{{"elapsed_s", elapsed}, {"answering", connection.answering}};
  if (!connection.answering || !statistics.latest()) return object;
  const protocol::Predictions& frame = statistics.latest()->frame;
  json targets = json::object();
  for (const WatchedTarget& target : statistics.targets()) {
    if (!target.latest) continue;
    json& entry = targets[target.name];
    entry["position_mm"] = target.latest->position;
    if (const auto radius = radius_95(target.latest->covariance)) entry["radius_95_mm"] = *radius;
    if (target.error) entry["error_mm"] = *target.error;
  }
  object.update({{"validity", protocol::to_string(frame.validity)},
                 {"reasons", reason_names(frame.reasons)},
                 {"tracker_frame", frame.tracker_frame},
                 {"age_ms", ms(statistics.age_ns(now_ns))},
                 {"rate_hz", statistics.rate_hz(now_ns)},
                 {"lost", statistics.lost()},
                 {"step_ms", ms(frame.step_time_ns)},
                 {"iterations", frame.iterations},
                 {"markers_used", frame.markers_used},
                 {"innovation_rms_mm", frame.innovation_rms},
                 {"alarm", alarm_json(frame.alarm)},
                 {"receive_to_send_ms", percentiles_json(percentiles_ms(statistics.recent_latency()))},
                 {"targets", targets}});
  return object;
}

std::string watch_summary(const WatchStatistics& statistics, double elapsed) {
  std::string text = fixed(elapsed, 1) + " s: " + std::to_string(statistics.frames()) + " frames, " +
                     std::to_string(statistics.lost()) + " lost";
  if (statistics.restarts() > 0) text += ", " + std::to_string(statistics.restarts()) + " restarts of the tracker";
  for (const auto& [validity, frames] : statistics.validity()) {
    text += ", " + fixed(percent(frames, statistics.frames()), 1) + " % " + protocol::to_string(validity);
  }
  text += '\n';
  TextTable table;
  table.add_row({"target", "mean error mm", "max error mm", "in 95 % ellipsoid"});
  bool judged = false;
  for (const WatchedTarget& target : statistics.targets()) {
    const ErrorStatistics& errors = target.errors;
    if (errors.frames == 0) continue;
    judged = true;
    const std::string inside = fixed(percent(errors.inside, errors.judged), 1);
    table.add_row({target.name, fixed(errors.mean(), 3), fixed(errors.most, 3), inside == "-" ? "-" : inside + " %"});
  }
  if (judged) text += table.text();
  if (statistics.frames() == 0) return text;
  return text + "receive to send  " + percentiles(percentiles_ms(statistics.latency())) + "\nstep             " +
         percentiles(percentiles_ms(statistics.step())) + "\n";
}

json watch_summary_json(const WatchStatistics& statistics, double elapsed) {
  json targets = json::object();
  for (const WatchedTarget& target : statistics.targets()) {
    const ErrorStatistics& errors = target.errors;
    if (errors.frames == 0) continue;
    targets[target.name] = {{"mean_error_mm", errors.mean()}, {"max_error_mm", errors.most}};
    if (errors.judged > 0) targets[target.name]["inside_95_percent"] = percent(errors.inside, errors.judged);
  }
  json validity = json::object();
  for (const auto& [word, frames] : statistics.validity()) validity[protocol::to_string(word)] = frames;
  return {{"summary",
           {{"elapsed_s", elapsed},
            {"frames", statistics.frames()},
            {"lost", statistics.lost()},
            {"restarts", statistics.restarts()},
            {"validity", validity},
            {"targets", targets},
            {"receive_to_send_ms", percentiles_json(percentiles_ms(statistics.latency()))},
            {"step_ms", percentiles_json(percentiles_ms(statistics.step()))}}}};
}

}  // namespace tissued::daemon
