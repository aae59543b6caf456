#include "daemon/ctl_calibrate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

#include "daemon/calibration.hpp"
#include "daemon/calibration_page.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/evaluation_trace.hpp"
#include "daemon/shared_calibration.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::daemon {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct CalibrateArguments {
  CalibrationRequest request;
  std::vector<std::string> vary;
  std::string start;
  double range = 0.4;
  GlobalSearchOptions global;
  int evaluations = 100;
  int threads = 0;  // 0: as many as the process has processors
  fs::path out;
};

// KEY=LOW..HIGH
VariedKey parse_varied(const std::string& text) {
  const std::size_t equals = text.find('='), dots = text.find("..", equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || equals == 0 || dots == std::string::npos)
    throw UsageError("--vary: `" + text + "` is not KEY=LOW..HIGH");
  const auto low = protocol::parse_number(text.substr(equals + 1, dots - equals - 1)),
             high = protocol::parse_number(text.substr(dots + 2));
  if (!low || !high) throw UsageError("--vary: `" + text + "` has bounds that are not numbers");
  if (!(*low < *high)) throw UsageError("--vary: `" + text + "`: the lower bound is not below the upper one");
  return {text.substr(0, equals), *low, *high};
}

std::vector<VariedKey> parse_all_varied(const std::vector<std::string>& texts) {
  std::vector<VariedKey> keys;
  for (const std::string& text : texts) {
    keys.push_back(parse_varied(text));
    const auto same = [&](const VariedKey& key) { return key.key == keys.back().key; };
    if (std::ranges::count_if(keys, same) > 1) throw UsageError("--vary: " + keys.back().key + " is given twice");
  }
  return keys;
}

// The values that a configuration has at the keys. Throws UsageError and config::ConfigError.
SearchPoint read_start(const std::string& path, const std::vector<VariedKey>& keys) {
  const config::Json document = config::read_json(path);
  SearchPoint start;
  for (const VariedKey& key : keys) {
    const config::JsonPointer place = pointer_to(key.key);
    if (!document.contains(place) || !document[place].is_number())
      throw UsageError("--start: " + path + " has no number at " + key.key);
    start.push_back(document[place].get<double>());
    if (start.back() < key.low || start.back() > key.high)
      throw UsageError("--start: " + path + ": " + key.key + " " + document[place].dump() + " is outside of --vary");
  }
  return start;
}

// All that decides the values that a search sees, and which it asks for.
std::string heading_of(const CalibrateArguments& a, const std::vector<VariedKey>& keys, const SearchPoint& start) {
  config::Json all = {{"bundle", fs::absolute(a.request.bundle).lexically_normal().string()},
                      {"model", a.request.model},
                      {"targets", a.request.targets},
                      {"trials", a.request.trials},
                      {"set", a.request.overrides}};
  for (const VariedKey& key : keys) all["vary"].push_back({key.key, key.low, key.high});
  if (start.empty()) {
    all.update({{"population", a.global.population}, {"generations", a.global.generations}, {"seed", a.global.seed}});
  } else {
    all.update({{"start", start}});
  }
  return all.dump();
}

// One line per batch: how far it is, the best so far, and how long the rest takes at most.
class CalibrationProgress {
 public:
  CalibrationProgress(std::size_t planned, std::size_t distances) : planned_(planned), distances_(distances) {}

  void show(std::size_t asked, std::size_t evaluated, const std::vector<double>& values) {
    asked_ += asked;
    evaluated_ += evaluated;
    for (const double value : values) best_ = std::min(best_, value);
    if (evaluated == 0) return;  // known from the trace
    const double elapsed = std::chrono::duration<double>(Clock::now() - begin_).count();
    const double each = elapsed / static_cast<double>(evaluated_);
    const double left = planned_ > asked_ ? each * static_cast<double>(planned_ - asked_) : 0.0;
    std::fprintf(stderr, "%zu of at most %zu points: best %.4f mm a target, at most %.0f s left\n", asked_, planned_,
                 best_ / static_cast<double>(distances_), std::ceil(left));
  }

 private:
  std::size_t planned_, distances_;
  std::size_t asked_ = 0, evaluated_ = 0;
  double best_ = INFINITY;
  Clock::time_point begin_ = Clock::now();
};

SearchResult search(const CalibrateArguments& a, const std::vector<VariedKey>& keys, const SearchPoint& start,
                    const Calibration& calibration, const SharedCalibration& shared, EvaluationTrace& trace) {
  const auto planned = static_cast<std::size_t>(start.empty() ? a.global.population * (a.global.generations + 1)
                                                              : a.evaluations + 2 * static_cast<int>(keys.size()) + 1);
  CalibrationProgress progress(planned, calibration.distances());
  const SearchObjective ask = [&](const std::vector<SearchPoint>& points) {
    const std::size_t before = trace.count();
    const std::vector<double> values = trace.evaluate(points, std::cref(shared));
    progress.show(points.size(), trace.count() - before, values);
    return values;
  };
  return start.empty() ? search_globally(keys, ask, a.global) : search_around(keys, start, ask, a.evaluations);
}

void write_file(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

int run_calibrate(CalibrateArguments a) {
  const MpiRanks ranks;
  std::vector<VariedKey> keys = parse_all_varied(a.vary);
  a.request.keys = keys;
  const Calibration calibration(a.request);
  const SharedCalibration shared(ranks, calibration, a.threads > 0 ? a.threads : ranks.processors());
  if (ranks.rank() != 0) {
    shared.serve();
    return kSuccess;
  }
  SearchPoint start;
  if (!a.start.empty()) {
    start = read_start(a.start, keys);
    keys = narrowed(keys, start, a.range);
  }
  fs::create_directories(a.out);
  EvaluationTrace trace(a.out / "evaluations.csv", heading_of(a, keys, start), keys);
  const SearchResult best = search(a, keys, start, calibration, shared, trace);
  if (best.value >= Calibration::kRefused)
    throw std::runtime_error("the configuration refuses every point between the bounds");
  write_file(a.out / "config.json", calibration.config_at(best.point).dump(1) + '\n');
  write_file(a.out / "index.html",
             calibration_page(a.request, keys, start, trace.rows(), best, calibration.distances()));
  for (std::size_t i = 0; i < keys.size(); ++i) std::printf("%s %.6g\n", keys[i].key.c_str(), best.point[i]);
  std::printf("%.4f mm a target over %zu, %zu points evaluated\n%s\n",
              best.value / static_cast<double>(calibration.distances()), calibration.distances(), trace.count(),
              (a.out / "config.json").c_str());
  return kSuccess;
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CalibrateArguments& a = *arguments;
  CLI::App* calibrate = app.add_subcommand("calibrate", "Numbers of a model that bring it closest to recordings");
  calibrate->footer(
      "Plays trials from rest and minimises the sum, over trials and targets, of the distance in the hold between "
      "where\n"
      "a target is predicted and where it was recorded. Without --start by a genetic algorithm over all that --vary "
      "allows;\n"
      "with it by compass search around a configuration. Writes DIR/config.json, which tissued --config loads, and\n"
      "DIR/evaluations.csv, every point that was evaluated; the same command goes on where that ends. DIR/index.html "
      "shows\n"
      "the search. Under mpirun, trials are shared out over its processes.\n"
      "Example: tissuectl calibrate recordings/paper/gel --model pbd --vary simulator.pbd.cluster_spacing=5..25 --vary "
      "simulator.pbd.cluster_radius=4..15 --out gel");
  calibrate->add_option("BUNDLE", a.request.bundle, "Folder with bundle.json")->type_name("")->required();
  calibrate->add_option("--model", a.request.model, "Simulator: pbd, fem or kf-admm")
      ->type_name("NAME")
      ->check(CLI::IsMember({"pbd", "fem", "kf-admm"}).description(""))
      ->required();
  calibrate
      ->add_option("--vary", a.vary,
                   "A number of the configuration (tissued --print-schema) and its bounds; may be repeated")
      ->type_name("KEY=LOW..HIGH")
      ->allow_extra_args(false)
      ->required();
  calibrate->add_option("--start", a.start, "Fine tuning from a configuration, such as config.json of a first guess")
      ->type_name("FILE");
  calibrate
      ->add_option("--range", a.range, "Of --start: bounds as wide as this share of --vary's, centred at the start")
      ->type_name("SHARE")
      ->check(in_range(1e-3, 2.0))
      ->capture_default_str();
  calibrate->add_option("--target", a.request.targets, "Targets, parted by commas; all")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  calibrate->add_option("--trials", a.request.trials, "Trials, parted by commas; all that are not held out")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->allow_extra_args(false);
  calibrate->add_option("--set", a.request.overrides, "Key of the configuration that stays; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  calibrate->add_option("--population", a.global.population, "Points of a generation")
      ->type_name("N")
      ->check(in_range(8, 10000))
      ->capture_default_str();
  calibrate->add_option("--generations", a.global.generations, "After the first, random one")
      ->type_name("N")
      ->check(in_range(1, 100000))
      ->capture_default_str();
  calibrate
      ->add_option("--evaluations", a.evaluations,
                   "Of --start: points after which it ends, with a round of two per key")
      ->type_name("N")
      ->check(in_range(1, 1000000))
      ->capture_default_str();
  calibrate->add_option("--seed", a.global.seed, "Of the population")->type_name("N")->capture_default_str();
  calibrate->add_option("--threads", a.threads, "Trials played at a time; as many as there are processors")
      ->type_name("N")
      ->check(in_range(1, 256));
  calibrate->add_option("--out", a.out, "Folder for the results; made where it is missing")
      ->type_name("DIR")
      ->required();
  calibrate->callback([arguments, &exit_code] { exit_code = run_calibrate(*arguments); });
}

}  // namespace tissued::daemon
