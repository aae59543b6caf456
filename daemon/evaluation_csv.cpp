#include "daemon/evaluation_csv.hpp"

#include <cmath>
#include <cstdio>
#include <functional>
#include <ostream>

#include "daemon/confidence.hpp"

namespace tissued::daemon {
namespace {

// RFC 4180.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string field(double value) {
  if (!std::isfinite(value)) return "";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

void write_row(std::ostream& out, const std::vector<std::string>& fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) out << (i > 0 ? "," : "") << fields[i];
  out << '\n';
}

using RowWriter =
    std::function<void(const std::vector<std::string>& key, const Recording& recording, const EvaluatedRun& run)>;

void for_each_run(const Evaluation& evaluation, const RowWriter& write) {
  for (const auto& bundle : evaluation.bundles()) {
    for (std::size_t r = 0; r < bundle->recordings.size(); ++r) {
      for (std::size_t s = 0; s < bundle->setups.size(); ++s) {
        const Setup& setup = bundle->setups[s];
        write({field(bundle->bundle.scene.name), field(bundle->recordings[r].name()), field(setup.model.name),
               field(setup.marker_set)},
              bundle->recordings[r], bundle->runs[s][r]);
      }
    }
  }
}

std::vector<std::string> target_fields(const TargetScore& target) {
  return {field(target.name),   std::to_string(target.frames),  field(target.hold_mm),    field(target.mean_mm),
          field(target.rms_mm), field(target.p95_mm),           field(target.max_mm),     field(target.inside_95),
          field(target.nees),   field(target.inside_95_sensor), field(target.nees_sensor)};
}

std::vector<std::string> run_fields(const RunScore& score) {
  return {field(score.innovation_rms_mm), std::to_string(score.frames), std::to_string(score.diverged),
          field(score.step_p50_ms), field(score.step_p99_ms)};
}

void append(std::vector<std::string>& row, const std::vector<std::string>& more) {
  row.insert(row.end(), more.begin(), more.end());
}

// mm per axis; nothing in open loop, where nothing is claimed.
std::string claimed_sd(const TargetSample& sample) {
  const double variance = sample.covariance[0] + sample.covariance[3] + sample.covariance[5];
  return variance > 0.0 ? field(std::sqrt(variance / 3.0)) : "";
}

std::vector<std::string> error_fields(const TargetSample& sample) {
  if (!sample.measured) return {"", "", "", "", ""};
  const core::Vec3 error = sample.error();
  const auto square = normalized_square(error, sample.covariance);
  return {field(error.x()), field(error.y()), field(error.z()), field(error.norm()),
          square ? field(*square) : std::string()};
}

}  // namespace

void write_runs_csv(const Evaluation& evaluation, std::ostream& out) {
  out << "bundle,trial,model,marker_set,target,compared_frames,hold_mm,mean_mm,rms_mm,p95_mm,max_mm,inside_95,nees,"
         "inside_95_sensor,nees_sensor,innovation_rms_mm,frames,diverged_frames,step_p50_ms,step_p99_ms\n";
  for_each_run(evaluation, [&out](const auto& key, const Recording&, const EvaluatedRun& run) {
    const auto write = [&](const std::vector<std::string>& of_target) {
      std::vector<std::string> row = key;
      append(row, of_target);
      append(row, run_fields(run.score));
      write_row(out, row);
    };
    for (const TargetScore& target : run.score.targets) write(target_fields(target));
    if (run.score.targets.empty()) write({"", "0", "", "", "", "", "", "", "", "", ""});
  });
}

void write_frames_csv(const Evaluation& evaluation, std::ostream& out) {
  out << "bundle,trial,model,marker_set,target,frame,time_s,contact,diverged,x_mm,y_mm,z_mm,sd_mm,error_x_mm,"
         "error_y_mm,error_z_mm,error_mm,nees\n";
  for_each_run(evaluation, [&out](const auto& key, const Recording& recording, const EvaluatedRun& run) {
    for (std::size_t t = 0; t < run.score.targets.size(); ++t) {
      for (const RunFrame& frame : run.recorded) {
        const TargetSample& sample = frame.targets[t];
        std::vector<std::string> row = key;
        append(row, {field(run.score.targets[t].name),
                     std::to_string(recording.first_frame() + static_cast<int>(frame.index)), field(frame.time),
                     frame.contact ? "1" : "0", frame.diverged ? "1" : "0", field(sample.position.x()),
                     field(sample.position.y()), field(sample.position.z()), claimed_sd(sample)});
        append(row, error_fields(sample));
        write_row(out, row);
      }
    }
  });
}

}  // namespace tissued::daemon
