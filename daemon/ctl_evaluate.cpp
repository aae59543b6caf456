#include "daemon/ctl_evaluate.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "daemon/ctl_options.hpp"
#include "daemon/evaluation.hpp"
#include "daemon/evaluation_csv.hpp"
#include "daemon/evaluation_page.hpp"
#include "daemon/evaluation_summary.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct EvaluateArguments {
  EvaluationRequest request;
  std::vector<std::string> models;
  std::vector<std::string> variants;
  fs::path out;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool frames = false;
};

// How many runs are done and how long the rest will take: one line that is written over at a terminal, else a new line
// now and then.
class EvaluationProgress {
 public:
  explicit EvaluationProgress(std::size_t runs) : runs_(runs) {}
  ~EvaluationProgress() {
    if (terminal_) std::fputs("\r\x1b[K", stderr);
  }

  void show(std::size_t done) {
    const Clock::time_point now = Clock::now();
    if (!terminal_ && done < runs_ && now - shown_ < kBetweenLines) return;
    shown_ = now;
    const double elapsed = std::chrono::duration<double>(now - begin_).count();
    const double left = elapsed / static_cast<double>(done) * static_cast<double>(runs_ - done);
    std::fprintf(stderr, terminal_ ? "\r%zu of %zu runs, %.0f s left\x1b[K" : "%zu of %zu runs, %.0f s left\n", done,
                 runs_, std::ceil(left));
  }

 private:
  static constexpr std::chrono::seconds kBetweenLines{5};
  std::size_t runs_;
  bool terminal_ = isatty(STDERR_FILENO) == 1;
  Clock::time_point begin_ = Clock::now();
  Clock::time_point shown_ = begin_;
};

std::vector<EvaluatedModel> chosen_models(const EvaluateArguments& arguments) {
  std::vector<EvaluatedModel> models;
  for (const std::string& name : arguments.models) models.push_back(named_model(name));
  for (const std::string& text : arguments.variants) models.push_back(parse_variant(text));
  if (models.empty()) {
    for (const char* name : {"admm", "kf-admm", "paper-admm", "paper"}) models.push_back(named_model(name));
  }
  for (auto model = models.begin(); model != models.end(); ++model) {
    if (std::ranges::count(models, model->name, &EvaluatedModel::name) > 1) {
      throw UsageError("two models are called `" + model->name + "`");
    }
  }
  return models;
}

// Open before the runs: what cannot be written should not be waited for.
std::ofstream open_output(const fs::path& path) {
  std::ofstream file(path);
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
  return file;
}

void close_output(std::ofstream& file, const fs::path& path) {
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": could not be written in full");
}

void warn_where_targets_are_not_measured(const Evaluation& evaluation) {
  for (const auto& bundle : evaluation.bundles()) {
    if (bundle->has_measured_target()) continue;
    std::fprintf(stderr, "tissuectl: %s: no target was measured in these trials; the columns of targets stay empty\n",
                 bundle->bundle.scene.name.c_str());
  }
}

int run_evaluate(EvaluateArguments arguments) {
  arguments.request.models = chosen_models(arguments);
  Evaluation evaluation(arguments.request);
  std::error_code not_created;
  fs::create_directories(arguments.out, not_created);
  if (not_created) throw std::runtime_error(arguments.out.string() + ": " + not_created.message());
  const fs::path runs_path = arguments.out / "runs.csv", page_path = arguments.out / "index.html",
                 frames_path = arguments.out / "frames.csv";
  std::ofstream runs = open_output(runs_path), page = open_output(page_path), frames;
  if (arguments.frames) frames = open_output(frames_path);

  {
    EvaluationProgress progress(evaluation.run_count());
    evaluation.run(arguments.threads, [&progress](std::size_t done) { progress.show(done); });
  }
  write_runs_csv(evaluation, runs);
  close_output(runs, runs_path);
  if (arguments.frames) {
    write_frames_csv(evaluation, frames);
    close_output(frames, frames_path);
  }
  page << evaluation_page(evaluation, arguments.threads);
  close_output(page, page_path);

  std::fputs(evaluation_summary(evaluation).c_str(), stdout);
  warn_where_targets_are_not_measured(evaluation);
  std::printf("%s\n", page_path.c_str());
  return kSuccess;
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  EvaluateArguments& a = *arguments;
  CLI::App* evaluate =
      app.add_subcommand("evaluate", "Recorded trials through simulators: errors as CSV and as a page");
  evaluate->footer(
      "Runs in this process, without a daemon and without losing frames, each trial from rest unless --session; what "
      "it\n"
      "scores is what tissued would have answered. Writes DIR/runs.csv and DIR/index.html, one file that needs nothing "
      "else.\n"
      "Models: " +
      join_or(model_names()) +
      ".\n"
      "Example: tissuectl evaluate recordings/paper/table1 --models admm,kf-admm --variant "
      "soft:material.youngs_modulus=5"
      " --out result");
  evaluate->add_option("BUNDLE", a.request.bundles, "Folders with bundle.json")->type_name("")->required();
  evaluate
      ->add_option("--models", a.models, "Models, parted by commas; admm,kf-admm,paper-admm,paper unless any is named")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  evaluate
      ->add_option(
          "--variant", a.variants,
          "One more model: a name for it, and keys of the configuration (tissued --print-schema) or a file that has "
          "them; may be repeated")
      ->type_name("NAME:KEY=VALUE,...|NAME:FILE.json")
      ->allow_extra_args(false);
  evaluate
      ->add_option("--marker-sets", a.request.marker_sets, "Sets of markers, parted by commas; every set of the bundle")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  evaluate->add_option("--trials", a.request.trials, "Trials, parted by commas; all")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  evaluate->add_option("--set", a.request.overrides, "Key of the configuration, for all models; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  evaluate->add_option("--threads", a.threads, "Runs at a time")
      ->type_name("N")
      ->check(in_range(1, 256))
      ->capture_default_str();
  evaluate->add_flag("--forces", a.request.pad_forces, "Feed the recorded pad forces, too");
  evaluate->add_flag("--session", a.request.session,
                     "A bundle's trials one after the other by one simulator, which keeps what it learns");
  evaluate->add_flag("--frames", a.frames, "Write DIR/frames.csv, too: every frame of every run");
  evaluate->add_option("--out", a.out, "Folder for the results; made where it is missing")
      ->type_name("DIR")
      ->required();
  evaluate->callback([arguments, &exit_code] { exit_code = run_evaluate(*arguments); });
}

}  // namespace tissued::daemon
