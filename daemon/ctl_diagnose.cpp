#include "daemon/ctl_diagnose.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include "daemon/ctl_options.hpp"
#include "daemon/diagnosis_json.hpp"
#include "daemon/diagnosis_page.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/session_loader.hpp"
#include "protocol/nexus_csv.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;

struct DiagnoseArguments {
  std::vector<std::string> bundles;
  fs::path out;
  int threads = 0;
  double budget = 140.0;
  bool quick = false;
};

// Set by SIGINT and SIGTERM: what is known by then is reported.
std::atomic<bool> interrupted{false};
void interrupt(int) { interrupted = true; }

// How far a diagnosis is: one line that is written over at a terminal, else a new line now and then.
class DiagnosisProgress {
 public:
  void show(double share, const std::string& what) {
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    if (!terminal_ && elapsed < shown_ + kBetweenLines) return;
    shown_ = elapsed;
    const double left = share > 0.0 ? elapsed * (1.0 - share) / share : 0.0;
    std::fprintf(stderr, terminal_ ? "\r%3.0f %%, about %.0f s left: %s\x1b[K" : "%3.0f %%, about %.0f s left: %s\n",
                 100.0 * share, std::ceil(left), what.c_str());
  }
  ~DiagnosisProgress() {
    if (terminal_) std::fputs("\r\x1b[K", stderr);
  }

 private:
  static constexpr double kBetweenLines = 5.0;  // s
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double shown_ = -kBetweenLines;
};

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

void print_findings(const core::Diagnosis& diagnosis) {
  std::printf("%s: %s\n", diagnosis.bundle.c_str(), std::string(core::name_of(diagnosis.verdict)).c_str());
  for (const core::Finding& finding : diagnosis.findings)
    std::printf("  %s (%.0f %%). %s\n", finding.title.c_str(), 100.0 * finding.probability, finding.summary.c_str());
  std::printf("  markers %.3f mm as assumed, %.3f with other numbers, %.3f as explained (noise %.3f)",
              diagnosis.trials.assumed.marker_mm, diagnosis.trials.parameters.marker_mm,
              diagnosis.trials.explained.marker_mm, diagnosis.noise_marker_mm);
  if (diagnosis.held_out_seen)
    std::printf("; held out %.3f, %.3f, %.3f", diagnosis.held_out.assumed.marker_mm,
                diagnosis.held_out.parameters.marker_mm, diagnosis.held_out.explained.marker_mm);
  std::printf("; %.0f s\n", diagnosis.seconds);
}

void diagnose_bundle(const std::string& folder, const fs::path& out, const DiagnoseArguments& arguments) {
  const config::Bundle bundle = config::load_bundle(folder);
  if (bundle.dynamic)
    throw std::runtime_error(folder + ": a dynamic bundle; only quasi-static recordings are diagnosed");
  const core::RecordedSession session = load_session(bundle);
  fs::create_directories(out);
  DiagnosisProgress progress;
  core::SearchOptions options;
  options.threads = arguments.threads;
  options.budget = arguments.budget;
  options.refine_mesh = !arguments.quick;
  options.interrupted = &interrupted;
  options.progress = [&progress](double share, const std::string& what) { progress.show(share, what); };
  const core::Diagnosis diagnosis = core::diagnose(session, options);
  write_text(out / "report.json", report_json(diagnosis).dump(1) + "\n");
  write_text(out / "report.html", diagnosis_page(diagnosis, session.scene));
  write_model(diagnosis, session.scene, out / "model.json");
  print_findings(diagnosis);
}

int run_diagnose(const DiagnoseArguments& arguments) {
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  for (const std::string& bundle : arguments.bundles) {
    const std::string name = fs::path(bundle).lexically_normal().filename().string();
    diagnose_bundle(bundle, arguments.bundles.size() == 1 ? arguments.out : arguments.out / name, arguments);
    if (interrupted) break;
  }
  return kSuccess;
}

struct PredictArguments {
  std::string bundle, trial;
  fs::path model, out;
};

// Markers and targets of every frame, in the tracker's frame.
protocol::Trial trial_of(const config::Bundle& bundle, const core::Scene& scene, const core::RecordedTrial& recorded,
                         const core::RowMatrix& displacements) {
  protocol::Trial trial;
  trial.rate_hz = scene.rate;
  trial.frame_count = recorded.time.size();
  const std::string prefix = bundle.subject.empty() ? "" : bundle.subject + ":";
  std::vector<core::Vec3> rests;
  for (const core::Marker& marker : scene.markers) {
    trial.add_label(prefix + marker.name);
    rests.push_back(marker.rest);
  }
  for (const core::Target& target : scene.targets) {
    trial.add_label(prefix + target.name);
    rests.push_back(target.rest);
  }
  const core::RigidTransform tracker_from_tissue = bundle.tissue_from_tracker.inverse();
  for (Eigen::Index f = 0; f < displacements.rows(); ++f) {
    for (std::size_t i = 0; i < rests.size(); ++i) {
      const core::Vec3 at =
          tracker_from_tissue(rests[i] + displacements.row(f).segment<3>(3 * static_cast<Eigen::Index>(i)).transpose());
      trial.positions.push_back({at.x(), at.y(), at.z()});
      trial.seen.push_back(1);
    }
  }
  return trial;
}

int run_predict(const PredictArguments& arguments) {
  const config::Bundle bundle = config::load_bundle(arguments.bundle);
  const core::RecordedSession session = load_session(bundle);
  const core::RecordedTrial* trial = nullptr;
  for (const auto* group : {&session.trials, &session.held_out})
    for (const core::RecordedTrial& candidate : *group)
      if (candidate.name == arguments.trial) trial = &candidate;
  if (trial == nullptr) throw UsageError("--trial: the bundle has no trial " + arguments.trial);
  ExplainedModel model;
  model.candidate.hypothesis.numbers = false;
  model.offset.setZero(core::channels_of(session.scene).count());
  if (!arguments.model.empty()) model = read_model(arguments.model, session.scene);
  const core::RowMatrix displacements = core::predict(session.scene, *trial, model.candidate, model.offset);
  protocol::write_nexus_csv(trial_of(bundle, session.scene, *trial, displacements), arguments.out);
  return kSuccess;
}

}  // namespace

void add_diagnose_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DiagnoseArguments>();
  DiagnoseArguments& a = *arguments;
  CLI::App* diagnose = app.add_subcommand("diagnose", "What is wrong where simulation and recordings differ?");
  diagnose->footer(
      "Writes report.json, report.html and model.json; of several bundles each into a folder of its name.\n"
      "Exit 0 whatever it finds. SIGINT ends it early with what is known by then.\n"
      "Example: tissuectl diagnose recordings/open/open-visco --out result");
  diagnose->add_option("BUNDLE", a.bundles, "Folders with bundle.json")->type_name("")->required();
  diagnose->add_option("--out", a.out, "Folder for the reports")->type_name("DIR")->required();
  diagnose->add_option("--threads", a.threads, "0: as many as there are processors")
      ->type_name("N")
      ->check(in_range(0, 256))
      ->capture_default_str();
  diagnose->add_option("--budget", a.budget, "What is not tried after so many seconds is left out, and said")
      ->type_name("SECONDS")
      ->check(in_range(1.0, 1e6))
      ->capture_default_str();
  diagnose->add_flag("--quick", a.quick, "Do not judge the elements by finer ones");
  diagnose->callback([arguments, &exit_code] { exit_code = run_diagnose(*arguments); });
}

void add_predict_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PredictArguments>();
  PredictArguments& a = *arguments;
  CLI::App* predict = app.add_subcommand("predict", "What a model says of a trial, from its pads alone");
  predict->footer(
      "Example: tissuectl predict recordings/open/open-visco --model result/model.json --trial held-a12-10 --out "
      "p.csv");
  predict->add_option("BUNDLE", a.bundle, "Folder with bundle.json")->type_name("")->required();
  predict->add_option("--model", a.model, "model.json of diagnose; the assumed physics unless given")
      ->type_name("FILE");
  predict->add_option("--trial", a.trial, "Name of the trial")->type_name("NAME")->required();
  predict->add_option("--out", a.out, "Markers and targets of every frame, Nexus CSV")->type_name("FILE")->required();
  predict->callback([arguments, &exit_code] { exit_code = run_predict(*arguments); });
}

}  // namespace tissued::daemon
