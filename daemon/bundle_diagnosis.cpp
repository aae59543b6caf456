#include "daemon/bundle_diagnosis.hpp"

#include <fstream>
#include <stdexcept>

#include "core/effects/wording.hpp"
#include "daemon/diagnosis_json.hpp"
#include "daemon/diagnosis_page.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/session_loader.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Under another name first: a reader finds the whole file or none.
template <typename Write>
void replace_file(const fs::path& path, const Write& write) {
  fs::path unfinished = path;
  unfinished += ".unfinished";
  write(unfinished);
  fs::rename(unfinished, path);
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

std::string fixed_or_dash(const json& summary, const char* key, int digits) {
  const json& value = summary.at(key);
  return value.is_number() ? fixed(value.get<double>(), digits) : "-";
}

}  // namespace

core::Diagnosis diagnose_bundle(const std::string& folder, const fs::path& out, const BundleDiagnosisOptions& options,
                                const std::atomic<bool>& interrupted,
                                const std::function<void(double, const std::string&)>& progress) {
  const config::Bundle bundle = config::load_bundle(folder);
  const core::RecordedSession session = load_session(bundle);
  if (session.trials.empty())
    throw std::runtime_error("bundle " + session.scene.name + " has no trials to explain" +
                             (session.held_out.empty() ? "" : "; what is held out is never fitted"));
  fs::create_directories(out);
  core::SearchOptions search;
  search.threads = options.threads;
  search.budget = options.budget;
  search.processor_time = options.processor_time;
  search.refine_mesh = !options.quick;
  search.interrupted = &interrupted;
  search.progress = progress;
  core::Diagnosis diagnosis = core::diagnose(session, search);
  replace_file(out / "report.json",
               [&](const fs::path& path) { write_text(path, report_json(diagnosis).dump(1) + "\n"); });
  replace_file(out / "report.html",
               [&](const fs::path& path) { write_text(path, diagnosis_page(diagnosis, session.scene)); });
  replace_file(out / "model.json", [&](const fs::path& path) { write_model(diagnosis, session.scene, path); });
  return diagnosis;
}

json summary_of(const core::Diagnosis& diagnosis) {
  std::string findings;
  for (const core::Finding& finding : diagnosis.findings)
    findings += (findings.empty() ? "" : ", ") + finding.kind + core::worded(" (%.0f %%)", 100.0 * finding.probability);
  const core::Misfits &fitted = diagnosis.trials, &held_out = diagnosis.held_out;
  return {{"bundle", diagnosis.bundle},
          {"verdict", core::name_of(diagnosis.verdict)},
          {"findings", findings},
          {"assumed_mm", number(fitted.assumed.marker_mm)},
          {"explained_mm", number(fitted.explained.marker_mm)},
          {"held_out_mm", diagnosis.held_out_seen ? number(held_out.explained.marker_mm) : json(nullptr)},
          {"noise_mm", number(diagnosis.noise_marker_mm)},
          {"seconds", diagnosis.seconds},
          {"complete", diagnosis.complete}};
}

std::string terminal_text(const core::Diagnosis& diagnosis) {
  std::string text = diagnosis.bundle + ": " + std::string(core::name_of(diagnosis.verdict)) + "\n";
  for (const core::Finding& finding : diagnosis.findings)
    text += "  " + finding.title + core::worded(" (%.0f %%). ", 100.0 * finding.probability) + finding.summary + "\n";
  text += core::worded("  markers %.3f mm as assumed, %.3f with other numbers, %.3f as explained (noise %.3f)",
                       diagnosis.trials.assumed.marker_mm, diagnosis.trials.parameters.marker_mm,
                       diagnosis.trials.explained.marker_mm, diagnosis.noise_marker_mm);
  if (diagnosis.held_out_seen)
    text += core::worded("; held out %.3f, %.3f, %.3f", diagnosis.held_out.assumed.marker_mm,
                         diagnosis.held_out.parameters.marker_mm, diagnosis.held_out.explained.marker_mm);
  return text + core::worded("; %.0f s\n", diagnosis.seconds);
}

std::string summary_table(const json& summaries) {
  TextTable table;
  table.add_row({"bundle", "verdict", "assumed", "explained", "held out", "noise", "seconds", "findings"});
  std::string failures;
  for (const json& summary : summaries) {
    const std::string folder = summary.at("folder");
    if (summary.contains("error")) {
      table.add_row({folder, "failed", "-", "-", "-", "-", "-", ""});
      failures += folder + ": " + summary.at("error").get<std::string>() + "\n";
      continue;
    }
    const std::string verdict = summary.at("verdict");
    table.add_row({folder, verdict + (summary.at("complete").get<bool>() ? "" : " (stopped early)"),
                   fixed_or_dash(summary, "assumed_mm", 3), fixed_or_dash(summary, "explained_mm", 3),
                   fixed_or_dash(summary, "held_out_mm", 3), fixed_or_dash(summary, "noise_mm", 3),
                   fixed_or_dash(summary, "seconds", 0), summary.at("findings")});
  }
  return table.text() + failures;
}

}  // namespace tissued::daemon
