#include "daemon/ctl_play.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "daemon/ctl_options.hpp"
#include "daemon/play_report.hpp"
#include "protocol/nexus_csv.hpp"

namespace tissued::daemon {
namespace {

struct PlayArguments {
  std::string bundle;
  std::vector<std::string> trials;
  Endpoint to = default_tracker();
  KeyOption keys;
  Endpoint watch = default_clients();
  PlayOptions options;
  std::string marker_set;
  std::string out;
  bool loop = false;
  bool json = false;
  bool no_truth = false;
  bool no_watch = false;
};

std::vector<Recording> load_recordings(const config::Bundle& bundle, const std::vector<std::string>& names) {
  std::vector<Recording> recordings;
  for (const std::string& name : names) {
    const config::TrialInfo* info = bundle.find_trial(name);
    if (info == nullptr) {
      std::vector<std::string> known;
      for (const config::TrialInfo& trial : bundle.trials) known.push_back(trial.name);
      throw UsageError("bundle " + bundle.scene.name + " has no trial " + name + "; it has " +
                       (known.empty() ? "none" : join_or(known)));
    }
    recordings.emplace_back(bundle, *info, read_trial(info->file));
  }
  return recordings;
}

const config::MarkerSet* chosen_markers(const config::Bundle& bundle, const std::string& name) {
  if (name.empty()) return nullptr;
  const config::MarkerSet* set = bundle.find_marker_set(name);
  if (set == nullptr) throw UsageError("bundle " + bundle.scene.name + " has no marker set " + name);
  return set;
}

std::vector<std::string> target_names(const config::Bundle& bundle) {
  std::vector<std::string> names;
  for (const core::Target& target : bundle.scene.targets) names.push_back(target.name);
  return names;
}

// Tells a person at a terminal what goes on; leaves nothing behind.
class ProgressLine {
 public:
  ~ProgressLine() { show(""); }
  void show(const std::string& text) const {
    if (isatty(STDERR_FILENO) == 1) std::fprintf(stderr, "\r%s\x1b[K", text.c_str());
  }
};

// The daemon as it introduces itself, and the subscription to its answers.
struct Answers {
  Answers(const Endpoint& daemon, const std::optional<protocol::SecretKey>& key) : client(daemon, key) {
    hello = client.hello();
    markers = client.names(protocol::NameKind::marker);
    targets = client.names(protocol::NameKind::target);
    pads = client.names(protocol::NameKind::pad);
    const protocol::SubscribeReply granted = client.subscribe({.what = protocol::kTargets});
    if (granted.lease_s == 0 || granted.rate_hz != 0.0) {
      throw std::runtime_error(to_string(daemon) + " does not stream its answer to every frame");
    }
    subscription = std::make_unique<Subscription>(client, protocol::kTargets, 0.0);
  }
  PredictionClient client;
  protocol::HelloReply hello;
  std::vector<std::string> markers;
  std::vector<std::string> targets;
  std::vector<std::string> pads;
  std::unique_ptr<Subscription> subscription;
};

// A recording of one scene played to another would give numbers, all of them wrong.
void require_same_scene(const config::Bundle& bundle, const Answers& answers) {
  const auto knows = [](const std::vector<std::string>& names, const auto& ours) {
    return ours.empty() ||
           std::ranges::any_of(ours, [&](const auto& o) { return std::ranges::count(names, o.name) > 0; });
  };
  const bool knows_targets = knows(answers.targets, bundle.scene.targets);
  const std::string_view model = answers.hello.model.view();
  if (knows_targets && knows(answers.markers, bundle.scene.markers)) {
    if (!bundle.scene.name.starts_with(model))  // it may be cut short
      std::fprintf(stderr,
                   "tissuectl: warning: %s runs `%s`, the bundle is `%s`: what follows may compare two bodies\n",
                   to_string(answers.client.daemon()).c_str(), std::string(model).c_str(), bundle.scene.name.c_str());
    return;
  }
  throw std::runtime_error(to_string(answers.client.daemon()) + " knows none of the bundle's " +
                           (knows_targets ? "markers" : "targets") + ": it runs `" +
                           std::string(answers.hello.model.view()) + "`, the bundle is `" + bundle.scene.name + "`");
}

void write_predictions(const PlayArguments& arguments, const config::Bundle& bundle, const Recording& recording,
                       const PlayedTrial& played, const Answers& answers) {
  std::filesystem::create_directories(arguments.out);
  protocol::write_nexus_csv(predictions_as_trial(bundle, recording, played, answers.targets, answers.pads),
                            std::filesystem::path(arguments.out) / (recording.name() + ".csv"));
}

nlohmann::json json_head(const config::Bundle& bundle, const PlayArguments& arguments, const Answers* answers) {
  nlohmann::json head{{"bundle", bundle.scene.name}, {"rate", arguments.options.speed}};
  if (answers == nullptr) return head;
  head["daemon"] = {{"version", answers->hello.version.view()},
                    {"model", answers->hello.model.view()},
                    {"simulator", answers->hello.simulator.view()}};
  return head;
}

// Throws where playing has shown nothing.
void print_report(const PlayArguments& arguments, const config::Bundle& bundle, const Answers* answers,
                  const PlayReport& report) {
  if (arguments.json) {
    nlohmann::json json = json_head(bundle, arguments, answers);
    json.update(report.json());
    std::puts(json.dump(1).c_str());
  } else {
    std::fputs(report.text(answers != nullptr).c_str(), stdout);
  }
  if (answers != nullptr && report.sent() > 0 && report.answered() == 0) {
    throw std::runtime_error("no frame was answered: does the tissued at " + to_string(arguments.watch) +
                             " listen for its tracker on " + to_string(arguments.to) + "?");
  }
}

// Plays the trials one after the other, again and again where so asked.
PlayReport play_all(const PlayArguments& arguments, const config::Bundle& bundle,
                    const std::vector<Recording>& recordings, const Answers* answers) {
  TrackerSender sender(arguments.to, arguments.keys.key_for(config::KeyRole::tracker));
  const StopSignal stop;
  TrialPlayer player(sender, answers != nullptr ? answers->subscription.get() : nullptr, arguments.options, stop);
  PlayReport report(target_names(bundle));
  const ProgressLine progress;
  const std::vector<std::string> known = answers != nullptr ? answers->targets : std::vector<std::string>{};
  do {
    for (const Recording& recording : recordings) {
      if (player.finished()) break;
      progress.show("playing " + recording.name());
      const PlayedTrial played = player.play(recording);
      report.add(recording.name(), played, target_errors(bundle, recording, played, known));
      if (!arguments.out.empty()) write_predictions(arguments, bundle, recording, played, *answers);
    }
  } while (arguments.options.stop_after > 0.0 && !player.finished());
  return report;
}

int run_play(PlayArguments arguments) {
  const config::Bundle bundle = config::load_bundle(arguments.bundle);
  arguments.options.items.marker_set = chosen_markers(bundle, arguments.marker_set);
  arguments.options.items.truth = !arguments.no_truth;
  if (arguments.loop && arguments.options.stop_after <= 0.0) arguments.options.stop_after = INFINITY;
  const std::vector<Recording> recordings = load_recordings(bundle, arguments.trials);

  std::unique_ptr<Answers> answers;
  if (!arguments.no_watch) {
    answers = std::make_unique<Answers>(arguments.watch, arguments.keys.key_for(config::KeyRole::client));
    require_same_scene(bundle, *answers);
  }
  const PlayReport report = play_all(arguments, bundle, recordings, answers.get());
  print_report(arguments, bundle, answers.get(), report);
  return kSuccess;
}

}  // namespace

void add_play_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PlayArguments>();
  PlayArguments& a = *arguments;
  CLI::App* play = app.add_subcommand(
      "play", "Stream recordings to tissued as a tracker would, and compare its answers with the recorded targets");
  play->footer(
      "Trials follow one another with frame numbers from 1 each, as after a restart of the tracker. Targets are\n"
      "judged in the hold, where every pad is at its largest push: mean prediction against mean recorded place.\n"
      "Example: tissuectl play recordings/paper/table1 exp01 exp02 --rate 2");
  play->add_option("BUNDLE", a.bundle, "Folder with bundle.json")->type_name("")->required();
  play->add_option("TRIAL", a.trials, "Trials of the bundle, Nexus CSV or C3D")->type_name("")->required();
  play->add_option("--rate", a.options.speed, "Times as fast as recorded; the stamps keep the recorded time")
      ->type_name("X")
      ->check(in_range(1e-3, 1e3))
      ->capture_default_str();
  add_endpoint(*play, "--to", a.to, "Where tissued listens for its tracker");
  add_endpoint(*play, "--watch", a.watch, "Where tissued answers its clients");
  add_keys(*play, a.keys);
  CLI::Option* blind = play->add_flag("--no-watch", a.no_watch, "Only send; ask for no answers");
  play->add_option("--marker-set", a.marker_set, "Send only this marker set of the bundle")->type_name("NAME");
  play->add_option("--lead-in", a.options.lead_in, "Seconds at rest before each trial: its opening frames, repeated")
      ->type_name("S")
      ->check(in_range(0.0, 3600.0))
      ->capture_default_str();
  play->add_option("--pause", a.options.pause, "Seconds of silence between trials")
      ->type_name("S")
      ->check(in_range(0.0, 3600.0))
      ->capture_default_str();
  play->add_flag("--forces", a.options.items.pad_forces, "Send the recorded pad forces, too");
  play->add_flag("--no-truth", a.no_truth, "Do not send the recorded targets (watchers then show no errors)");
  play->add_flag("--loop", a.loop, "Begin again after the last trial, until Ctrl-C");
  play->add_option("--seconds", a.options.stop_after, "Play, over and over if need be, for this long")
      ->type_name("S")
      ->check(in_range(0.01, 1e6));
  play->add_option("--out", a.out, "Folder for TRIAL.csv: predicted targets and pad forces of every frame")
      ->type_name("DIR")
      ->excludes(blind);
  play->add_flag("--json", a.json, "Print JSON in place of the table");
  play->callback([arguments, &exit_code] { exit_code = run_play(*arguments); });
}

}  // namespace tissued::daemon
