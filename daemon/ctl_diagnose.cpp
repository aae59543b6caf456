#include "daemon/ctl_diagnose.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>

#include "daemon/bundle_diagnosis.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/session_loader.hpp"
#include "daemon/shared_jobs.hpp"
#include "protocol/nexus_csv.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;

struct DiagnoseArguments {
  std::vector<std::string> bundles;
  fs::path out;
  BundleDiagnosisOptions options;
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

int diagnose_one(const DiagnoseArguments& arguments) {
  std::string text;
  {
    DiagnosisProgress progress;
    text = terminal_text(
        diagnose_bundle(arguments.bundles.front(), arguments.out, arguments.options, interrupted,
                        [&progress](double share, const std::string& what) { progress.show(share, what); }));
  }
  std::fputs(text.c_str(), stdout);
  return kSuccess;
}

std::string name_of_folder(const std::string& bundle) {
  const fs::path path = fs::path(bundle).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

// One line for each bundle that is done, and a table of all at the end; `processors` of this rank share the bundles.
int diagnose_several(const MpiRanks& ranks, int processors, const DiagnoseArguments& arguments) {
  const auto count = static_cast<int>(arguments.bundles.size());
  const int workers = std::min(processors, (count + ranks.size() - 1) / ranks.size());
  BundleDiagnosisOptions options = arguments.options;
  options.threads = std::max(1, processors / workers);
  const auto diagnose = [&](int i) -> nlohmann::json {
    const std::string& folder = arguments.bundles[static_cast<std::size_t>(i)];
    const std::string name = name_of_folder(folder);
    try {
      nlohmann::json summary = summary_of(diagnose_bundle(folder, arguments.out / name, options, interrupted, {}));
      summary["folder"] = name;
      return summary;
    } catch (const std::exception& error) {
      return {{"folder", name}, {"error", error.what()}};
    }
  };
  int done = 0;
  const auto tell = [&](int, const nlohmann::json& summary) {
    const bool failed = summary.contains("error");
    const std::string what = summary.at(failed ? "error" : "verdict");
    std::fprintf(stderr, "%d of %d: %s: %s%s\n", ++done, count, summary.at("folder").get<std::string>().c_str(),
                 failed ? "failed: " : "", what.c_str());
  };
  nlohmann::json summaries = share_jobs(ranks, count, workers, diagnose, tell, [] { return interrupted.load(); });
  if (ranks.rank() != 0) return kSuccess;
  bool failed = false;
  for (int i = 0; i < count; ++i) {
    nlohmann::json& summary = summaries[static_cast<std::size_t>(i)];
    if (summary.is_null())
      summary = {{"folder", name_of_folder(arguments.bundles[static_cast<std::size_t>(i)])},
                 {"error", "not begun before the interruption"}};
    failed = failed || summary.contains("error");
  }
  std::fputs(summary_table(summaries).c_str(), stdout);
  return failed ? kFailure : kSuccess;
}

int run_diagnose(const DiagnoseArguments& arguments) {
  const MpiRanks ranks;
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  std::set<std::string> names;
  for (const std::string& bundle : arguments.bundles)
    if (!names.insert(name_of_folder(bundle)).second)
      throw UsageError("BUNDLE: two are called " + name_of_folder(bundle) +
                       ", and each writes to a folder of its name");
  if (arguments.bundles.size() == 1) return ranks.rank() == 0 ? diagnose_one(arguments) : kSuccess;
  return diagnose_several(ranks, arguments.options.threads > 0 ? arguments.options.threads : ranks.processors(),
                          arguments);
}

struct PredictArguments {
  std::string bundle, trial;
  fs::path model, out, recorded;
};

// Markers and targets of every frame, in the tracker's frame; what is not finite is a gap.
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
      trial.seen.push_back(at.allFinite() ? 1 : 0);
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
  core::RecordedTrial asked = *trial;
  if (const auto late = model.released.find(trial->name); asked.motion && late != model.released.end())
    asked.motion->release += late->second;
  const core::RowMatrix displacements = core::predict(session.scene, asked, model.candidate, model.offset);
  protocol::write_nexus_csv(trial_of(bundle, session.scene, *trial, displacements), arguments.out);
  if (!arguments.recorded.empty())
    protocol::write_nexus_csv(trial_of(bundle, session.scene, *trial, trial->seen), arguments.recorded);
  return kSuccess;
}

}  // namespace

void add_diagnose_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DiagnoseArguments>();
  DiagnoseArguments& a = *arguments;
  CLI::App* diagnose = app.add_subcommand("diagnose", "What is wrong where simulation and recordings differ?");
  diagnose->footer(
      "Writes report.json, report.html and model.json; of several bundles each into a folder of its name, and a table "
      "of\n"
      "all. Several are shared out over the processors and, under mpirun, over machines that see the same folders.\n"
      "Exit 0 whatever it finds, 1 where a bundle could not be diagnosed. SIGINT ends it early with what is known by\n"
      "then; mpirun must be told to wait for that: --mca odls_base_sigkill_timeout 60.\n"
      "Examples: tissuectl diagnose recordings/open/open-visco --out result\n"
      "          mpirun -n 4 tissuectl diagnose recordings/open/* --out results");
  diagnose->add_option("BUNDLE", a.bundles, "Folders with bundle.json")->type_name("")->required();
  diagnose->add_option("--out", a.out, "Folder for the reports")->type_name("DIR")->required();
  diagnose->add_option("--threads", a.options.threads, "0: as many as there are processors; of each rank under mpirun")
      ->type_name("N")
      ->check(in_range(0, 256))
      ->capture_default_str();
  diagnose->add_option("--budget", a.options.budget, "What is not tried after so many seconds is left out, and said")
      ->type_name("SECONDS")
      ->check(in_range(1.0, 1e6))
      ->capture_default_str();
  diagnose->add_flag(
      "--processor-time", a.options.processor_time,
      "The budget is of each thread's time on its processor: other work on the machine cuts nothing off");
  diagnose->add_flag("--quick", a.options.quick, "Do not judge the elements by finer ones");
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
  predict->add_option("--recorded", a.recorded, "What was recorded of them, cleaned and turned as a diagnosis sees it")
      ->type_name("FILE");
  predict->callback([arguments, &exit_code] { exit_code = run_predict(*arguments); });
}

}  // namespace tissued::daemon
