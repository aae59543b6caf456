#include "daemon/ctl_track.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "daemon/ctl_options.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/pacing.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/simulated_tracker.hpp"
#include "daemon/stop_signal.hpp"
#include "daemon/tracker_sender.hpp"
#include "daemon/unreliable_channel.hpp"

namespace tissued::daemon {
namespace {

struct TrackArguments {
  std::string bundle;
  Endpoint to = default_tracker();
  KeyOption keys;
  double seconds = 0.0;  // 0: until a signal
  TrackerSimulation simulation;
  std::string pattern = "in-turn";
  std::vector<std::string> probes;
  std::vector<std::string> truth{"material.poissons_ratio=0.42"};
  ChannelFaults faults;
  double delay_ms = 0.0;
  double jitter_ms = 0.0;
  bool no_truth = false;
  bool json = false;
};

std::uint64_t ms_to_ns(double ms) { return static_cast<std::uint64_t>(std::llround(ms * 1e6)); }

struct TrackCounts {
  std::uint64_t frames = 0;
  std::uint64_t late = 0;  // frames that were not simulated in time
  double seconds = 0.0;
};

// Sends what arrives by `until_ns`, each datagram when it does.
void deliver(UnreliableChannel& channel, TrackerSender& sender, std::uint64_t until_ns) {
  while (const auto due = channel.due_ns()) {
    if (*due > until_ns) return;
    sleep_until_ns(*due);
    sender.send(channel.receive());
  }
}

TrackCounts run_tracker(SimulatedTracker& tracker, UnreliableChannel& channel, TrackerSender& sender,
                        const TrackArguments& arguments, const StopSignal& stop) {
  const double rate = arguments.simulation.rate_hz;
  const double frames = arguments.seconds > 0.0 ? std::round(arguments.seconds * rate) : INFINITY;
  std::array<protocol::TrackerPacket, protocol::kMaxPacketsPerFrame> packets;
  TrackCounts counts;
  const std::uint64_t start = monotonic_ns();
  std::uint64_t due = start;
  for (; static_cast<double>(counts.frames) < frames && !stop.requested(); ++counts.frames) {
    due = start + static_cast<std::uint64_t>(std::llround(static_cast<double>(counts.frames) / rate * 1e9));
    protocol::TrackerFrame frame = tracker.next();
    if (arguments.no_truth) frame.truth.clear();
    const std::size_t count = protocol::encode_tracker_frame(frame, packets);
    if (count == 0) throw std::runtime_error("the simulated tissue left all bounds: push less, or slower");
    counts.late += monotonic_ns() > due ? 1 : 0;
    deliver(channel, sender, due);
    for (std::size_t i = 0; i < count; ++i) channel.send(packets[i], due);
    deliver(channel, sender, due);
    sleep_until_ns(due);
  }
  deliver(channel, sender, UINT64_MAX);
  counts.seconds = static_cast<double>(due - start) * 1e-9;
  return counts;
}

void print_summary(const TrackArguments& arguments, const TrackCounts& counts, const ChannelCounts& channel) {
  if (arguments.json) {
    const nlohmann::json json{{"frames", counts.frames},       {"late", counts.late},
                              {"seconds", counts.seconds},     {"datagrams", channel.in},
                              {"lost", channel.lost},          {"duplicated", channel.duplicated},
                              {"held_back", channel.held_back}};
    std::puts(json.dump().c_str());
    return;
  }
  std::printf("%llu frames in %.1f s to %s: %llu datagrams, %llu lost, %llu duplicated, %llu held back; %llu late\n",
              static_cast<unsigned long long>(counts.frames), counts.seconds, to_string(arguments.to).c_str(),
              static_cast<unsigned long long>(channel.in), static_cast<unsigned long long>(channel.lost),
              static_cast<unsigned long long>(channel.duplicated), static_cast<unsigned long long>(channel.held_back),
              static_cast<unsigned long long>(counts.late));
}

int run_track(TrackArguments arguments) {
  arguments.simulation.pattern = push_pattern_of(arguments.pattern).value();
  arguments.faults.delay_ns = ms_to_ns(arguments.delay_ms);
  arguments.faults.jitter_ns = ms_to_ns(arguments.jitter_ms);
  arguments.faults.reorder_hold_ns = ms_to_ns(1500.0 / arguments.simulation.rate_hz);  // one frame overtakes it

  const config::Bundle bundle = config::load_bundle(arguments.bundle, arguments.truth);
  for (const std::string& script : arguments.probes) arguments.simulation.probes.push_back(parse_probe_script(script));
  SimulatedTracker tracker(load_scene(bundle), bundle.tissue_from_tracker, arguments.simulation, bundle.probe_images);
  UnreliableChannel channel(arguments.faults, arguments.simulation.seed);
  TrackerSender sender(arguments.to, arguments.keys.key_for(config::KeyRole::tracker));
  const StopSignal stop;
  const TrackCounts counts = run_tracker(tracker, channel, sender, arguments, stop);
  print_summary(arguments, counts, channel.counts());
  return kSuccess;
}

void add_simulation_options(CLI::App& track, TrackArguments& a) {
  const CLI::Validator share = in_range(0.0, 1.0);
  track.add_option("--rate", a.simulation.rate_hz, "Frames per second, Hz")
      ->type_name("HZ")
      ->check(in_range(1.0, 2000.0))
      ->capture_default_str();
  track.add_option("--noise", a.simulation.noise, "Of every marker sample, mm, standard deviation per axis")
      ->type_name("MM")
      ->check(in_range(0.0, 100.0))
      ->capture_default_str();
  track.add_option("--dropout", a.simulation.dropout, "Share of marker samples not seen, in gaps of 0.1 s on average")
      ->type_name("SHARE")
      ->check(share)
      ->capture_default_str();
  track
      .add_option("--placement", a.simulation.placement_error,
                  "How far markers are glued from where they should be, mm, standard deviation per axis")
      ->type_name("MM")
      ->check(in_range(0.0, 100.0))
      ->capture_default_str();
  track
      .add_option("--truth-set", a.truth,
                  "KEY=VALUE of bundle.json in which the simulated tissue differs from the bundle; may be repeated. "
                  "(A stiffer tissue moved by the same pads takes the same shape; another Poisson's ratio does not.)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->capture_default_str();
  const auto names = push_pattern_names();
  const std::vector<std::string> patterns(names.begin(), names.end());
  track.add_option("--pattern", a.pattern, "How the pads push: " + join_or(patterns))
      ->type_name("NAME")
      ->check(CLI::IsMember(patterns).description(""))
      ->capture_default_str();
  track.add_option("--push", a.simulation.push, "How far a pad pushes, mm")
      ->type_name("MM")
      ->check(in_range(0.0, 1000.0))
      ->capture_default_str();
  track.add_option("--period", a.simulation.period, "Time of one push: in, hold, out, rest, s")
      ->type_name("S")
      ->check(in_range(0.01, 3600.0))
      ->capture_default_str();
  track.add_option("--seed", a.simulation.seed, "Equal seeds give equal datagrams")
      ->type_name("N")
      ->capture_default_str();
}

void add_probe_options(CLI::App& track, TrackArguments& a) {
  track
      .add_option(
          "--probe", a.probes,
          "A probe of the bundle and what it does over the top of the body, again and again: press, slide, hold, "
          "lift; may be repeated")
      ->type_name("NAME=press,slide,lift")
      ->allow_extra_args(false);
  track.add_option("--probe-depth", a.simulation.probe_depth, "How far a probe presses below the skin at rest, mm")
      ->type_name("MM")
      ->check(in_range(0.0, 100.0))
      ->capture_default_str();
  track.add_option("--probe-seconds", a.simulation.probe_seconds, "Time of one move of a probe, s")
      ->type_name("S")
      ->check(in_range(0.1, 60.0))
      ->capture_default_str();
}

void add_channel_options(CLI::App& track, TrackArguments& a) {
  const CLI::Validator share = in_range(0.0, 1.0);
  const CLI::Validator milliseconds = in_range(0.0, 60000.0);
  track.add_option("--loss", a.faults.loss, "Share of datagrams lost")
      ->type_name("SHARE")
      ->check(share)
      ->capture_default_str();
  track.add_option("--reorder", a.faults.reorder, "Share of datagrams that later ones overtake")
      ->type_name("SHARE")
      ->check(share)
      ->capture_default_str();
  track.add_option("--duplicate", a.faults.duplicate, "Share of datagrams that come twice")
      ->type_name("SHARE")
      ->check(share)
      ->capture_default_str();
  track.add_option("--delay-ms", a.delay_ms, "Delay of every datagram")
      ->type_name("MS")
      ->check(milliseconds)
      ->capture_default_str();
  track.add_option("--jitter-ms", a.jitter_ms, "And up to this much more, at random")
      ->type_name("MS")
      ->check(milliseconds)
      ->capture_default_str();
}

}  // namespace

void add_track_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<TrackArguments>();
  TrackArguments& a = *arguments;
  CLI::App* track = app.add_subcommand(
      "track", "Simulate a tracking system beside a tissue that pads push, with noise, occlusions and network faults");
  track->footer(
      "The tissue is simulated open loop with other numbers than the bundle's (--truth-set), and the markers are glued "
      "a\n"
      "little off their places. The true targets ride along, so that watchers can show errors.\n"
      "Example: tissuectl track recordings/paper/table1 --dropout 0.1 --loss 0.02");
  track->add_option("BUNDLE", a.bundle, "Folder with bundle.json; its recordings are not used")
      ->type_name("")
      ->required();
  add_endpoint(*track, "--to", a.to, "Where tissued listens for its tracker");
  add_keys(*track, a.keys);
  track->add_option("--seconds", a.seconds, "End after this long; otherwise by Ctrl-C")
      ->type_name("S")
      ->check(in_range(0.0, 1e6));
  add_simulation_options(*track, a);
  add_probe_options(*track, a);
  add_channel_options(*track, a);
  track->add_flag("--no-truth", a.no_truth, "Do not send the true targets");
  track->add_flag("--json", a.json, "Print the summary as JSON");
  track->callback([arguments, &exit_code] { exit_code = run_track(*arguments); });
}

}  // namespace tissued::daemon
