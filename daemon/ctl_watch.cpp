#include "daemon/ctl_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "daemon/ctl_options.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/overlay_writer.hpp"
#include "daemon/stop_signal.hpp"
#include "daemon/subscription.hpp"
#include "daemon/watch_page.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr std::uint64_t kPage_ns = kSecond_ns / 10;     // between two pages
constexpr std::uint64_t kSilence_ns = kSecond_ns / 4;   // of the stream, after which it is asked for
constexpr std::uint64_t kDead_ns = 3 * kSecond_ns / 2;  // without any word the daemon counts as gone
constexpr Patience kShortPatience{std::chrono::milliseconds(150), 2};

struct WatchArguments {
  Endpoint from = default_clients();
  KeyOption keys;
  double seconds = 0.0;  // 0: until a signal
  bool json = false;
  OverlayRequest overlay;
};

// The conversation: introduces itself, listens, asks when it is quiet, begins again when the daemon is another one.
class Watcher {
 public:
  Watcher(const Endpoint& daemon, const std::optional<protocol::SecretKey>& key)
      : client_(daemon, key, kShortPatience),
        subscription_(client_, protocol::kTargets, 0.0),
        start_ns_(monotonic_ns()) {}

  // Listens until `deadline_ns` or a signal.
  void run_until(std::uint64_t deadline_ns) {
    if (!introduced_) introduce();
    while (const auto message = subscription_.receive(deadline_ns)) take(*message);
    const std::uint64_t now = monotonic_ns();
    if (introduced_ && now - heard_ns_ > kDead_ns) introduced_ = false;
    if (introduced_ && now - streamed_ns_ > kSilence_ns) client_.send(protocol::QueryTargets{});
    statistics_.tick(now);
  }

  Connection connection() const {
    const std::uint64_t since = heard_ns_ == 0 ? start_ns_ : heard_ns_;
    return {to_string(client_.daemon()), introduced_, static_cast<double>(monotonic_ns() - since) * 1e-9};
  }
  const WatchStatistics& statistics() const { return statistics_; }

 private:
  void introduce() {
    try {
      const protocol::HelloReply hello = client_.hello();
      const auto targets = client_.names(protocol::NameKind::target);
      statistics_.introduce(hello, targets, client_.names(protocol::NameKind::pad));
      heard_ns_ = streamed_ns_ = monotonic_ns();
      introduced_ = true;
    } catch (const NoAnswer&) {
      // Asked again before the next page.
    }
  }

  void take(const ReceivedMessage& message) {
    // Numbers that begin anew are another daemon: its tables may differ.
    if (introduced_ && session_ && *session_ != message.envelope.session) introduced_ = false;
    session_ = message.envelope.session;
    heard_ns_ = message.receive_ns;
    const auto* part = std::get_if<protocol::Predictions>(&message.message);
    if (part == nullptr || !introduced_) return;
    const bool streamed = message.envelope.in_reply_to == 0;
    const auto answer = (streamed ? streamed_ : asked_).add(*part, message.receive_ns);
    if (!answer) return;
    if (!streamed) return statistics_.add_asked(*answer);
    streamed_ns_ = message.receive_ns;
    statistics_.add_streamed(*answer);
  }

  PredictionClient client_;
  Subscription subscription_;
  AnswerJoiner streamed_, asked_;
  WatchStatistics statistics_;
  std::optional<std::uint32_t> session_;
  bool introduced_ = false;
  std::uint64_t start_ns_;
  std::uint64_t heard_ns_ = 0;
  std::uint64_t streamed_ns_ = 0;
};

// Calls `show` every `interval_ns` until the time is up or a signal comes.
template <typename Show>
void watch_loop(Watcher& watcher, const WatchArguments& arguments, std::uint64_t interval_ns, const Show& show) {
  const StopSignal stop;
  const std::uint64_t start = monotonic_ns();
  const auto length = static_cast<std::uint64_t>(std::llround(arguments.seconds * 1e9));
  const std::uint64_t end = length > 0 ? start + length : UINT64_MAX;
  std::uint64_t next = start;
  while (!stop.requested() && monotonic_ns() < end) {
    next += interval_ns;
    while (!stop.requested() && monotonic_ns() < std::min(next, end)) {
      watcher.run_until(std::min({next, end, monotonic_ns() + kPage_ns}));
    }
    show(static_cast<double>(monotonic_ns() - start) * 1e-9);
  }
}

void print_line(const std::string& line) {
  std::puts(line.c_str());
  std::fflush(stdout);
}

int run_overlay(const WatchArguments& arguments) {
  if (arguments.overlay.images.empty() || arguments.overlay.folder.empty())
    throw UsageError("--overlay IMAGE... and --out FOLDER go together, and --probe with them");
  if (arguments.json || arguments.seconds > 0.0) throw UsageError("--overlay goes without --json and --seconds");
  PredictionClient client(arguments.from, arguments.keys.key_for(config::KeyRole::client));
  write_overlays(client, arguments.overlay);
  return kSuccess;
}

int run_watch(const WatchArguments& arguments) {
  const OverlayRequest& overlay = arguments.overlay;
  if (!overlay.images.empty() || !overlay.folder.empty() || !overlay.probe.empty()) return run_overlay(arguments);
  Watcher watcher(arguments.from, arguments.keys.key_for(config::KeyRole::client));
  const std::uint64_t start = monotonic_ns();
  if (!arguments.json && stdout_is_terminal()) {
    FullScreen screen;
    watch_loop(watcher, arguments, kPage_ns, [&](double) {
      const TerminalStyle style = terminal_style();
      screen.draw(watch_page(watcher.statistics(), watcher.connection(), style, monotonic_ns()), style);
    });
  } else {
    watch_loop(watcher, arguments, kSecond_ns, [&](double elapsed) {
      const Connection connection = watcher.connection();
      const std::uint64_t now = monotonic_ns();
      print_line(arguments.json ? watch_json(watcher.statistics(), connection, elapsed, now).dump()
                                : watch_line(watcher.statistics(), connection, elapsed, now));
    });
  }
  const double elapsed = static_cast<double>(monotonic_ns() - start) * 1e-9;
  if (!watcher.statistics().hello()) {
    throw NoAnswer("no answer from " + to_string(arguments.from) + ": is tissued running there?");
  }
  if (arguments.json) {
    print_line(watch_summary_json(watcher.statistics(), elapsed).dump());
  } else {
    std::fputs(watch_summary(watcher.statistics(), elapsed).c_str(), stdout);
  }
  return kSuccess;
}

}  // namespace

void add_watch_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<WatchArguments>();
  WatchArguments& a = *arguments;
  CLI::App* watch =
      app.add_subcommand("watch", "Follow the predictions live, with their errors where the tracker streams the truth");
  watch->footer(
      "Shows every target with the longest semi-axis of its 95 % ellipsoid, rate, latency and lost frames; in the end\n"
      "a summary. Outside of a terminal: one line a second. Exit 1 where no daemon answered.\n"
      "Examples: tissuectl watch --seconds 30\n"
      "          tissuectl watch --overlay frame01.png frame02.png --out drawn");
  add_endpoint(*watch, "--from", a.from, "Where tissued answers its clients");
  add_keys(*watch, a.keys);
  watch->add_option("--seconds", a.seconds, "End after this long; otherwise by Ctrl-C")
      ->type_name("S")
      ->check(in_range(0.0, 1e6));
  watch->add_flag("--json", a.json, "One JSON object a second, the summary last");
  watch
      ->add_option("--overlay", a.overlay.images,
                   "Draw the targets on these ultrasound images instead, PNG, each with the next frame's answer")
      ->type_name("IMAGE...")
      ->check(CLI::ExistingFile.description(""));
  watch->add_option("--out", a.overlay.folder, "Where the drawn images go, under the same names")->type_name("FOLDER");
  watch->add_option("--probe", a.overlay.probe, "Whose images they are; the first probe unless given")
      ->type_name("NAME");
  watch->callback([arguments, &exit_code] { exit_code = run_watch(*arguments); });
}

}  // namespace tissued::daemon
