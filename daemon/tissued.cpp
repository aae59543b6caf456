// tissued: tracker packets in, targets out. Exit codes: 0 done, 1 the machine refused (port, memory), 2 usage,
// configuration, bundle or mesh refused.
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <memory>

#include "config/schema.hpp"
#include "core/simulator.hpp"
#include "daemon/alarm_report.hpp"
#include "daemon/answer_messages.hpp"
#include "daemon/bound_socket.hpp"
#include "daemon/log_output.hpp"
#include "daemon/runtime.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/start_options.hpp"

namespace tissued::daemon {
namespace {

constexpr int kRefusedByMachine = 1;
constexpr int kRefusedInput = 2;

void warn_of_unsealed(const config::DaemonConfig& config) {
  const bool sealed = !config.keys.empty();
  const auto warn = [](const char* what, const std::string& address, const std::string& whom) {
    spdlog::warn("{} listens on {}: {} IS BELIEVED WITHOUT A KEY. Nothing is encrypted or authenticated.", what,
                 address, whom);
  };
  const config::TrackerConfig& tracker = config.tracker;
  if (!config::is_loopback(tracker.address) && (!sealed || !tracker.peer.empty()))
    warn("tracker", tracker.address, tracker.peer.empty() ? "WHOEVER REACHES IT" : "WHOEVER WRITES AS " + tracker.peer);
  if (!config::is_loopback(config.clients.address) && !sealed)
    warn("clients", config.clients.address, "WHOEVER REACHES IT");
}

void log_alarm(const AlarmAnswer& alarm) {
  if (alarm.raised) {
    spdlog::warn("alarm: markers contradict the assumed physics, a diagnosis is due: {}",
                 alarm_text(alarm_state(alarm)));
  } else {
    spdlog::warn("alarm cleared: {}", alarm_text(alarm_state(alarm)));
  }
}

void log_summary(const Runtime& runtime, const core::Simulator& simulator) {
  const Counters& counters = runtime.counters();
  const LatencyWindow& latency = runtime.server().answers().latency();
  const LatencyWindow& step = runtime.server().answers().step_time();
  const auto ms = [](std::uint64_t ns) { return static_cast<double>(ns) * 1e-6; };
  spdlog::info(
      "done: {} frames stepped, {} skipped; rest markers {} um off; step p50 {:.2f} p99 {:.2f} ms; receive-to-send p50 "
      "{:.2f} p99 {:.2f} max {:.2f} ms; state {:016x}",
      counters[Count::frames_stepped], counters[Count::frames_skipped], counters[Count::registration_rms_um],
      ms(step.percentile_ns(0.5)), ms(step.percentile_ns(0.99)), ms(latency.percentile_ns(0.5)),
      ms(latency.percentile_ns(0.99)), ms(latency.max_ns()), simulator.state_hash());
}

void log_reload(const config::DaemonConfig& running, const config::DaemonConfig& wanted) {
  set_log_level(wanted.log.level);
  const std::vector<std::string> left = changes_that_need_a_start(running, wanted);
  if (left.empty()) return spdlog::warn("configuration read again");
  std::string pointers;
  for (const std::string& pointer : left) pointers.append(pointers.empty() ? "" : ", ").append(pointer);
  spdlog::warn("configuration read again; changed, but only a start takes it on: {}", pointers);
}

int serve(const config::DaemonConfig& config, core::Simulator& simulator, const StartOptions& options) {
  warn_of_unsealed(config);
  Runtime runtime(config, simulator, [](const std::string& line) { spdlog::error("{}", line); });
  runtime.stop_on_signals();
  runtime.on_alarm(log_alarm);
  runtime.on_strangers([](std::uint64_t names) {
    spdlog::warn(
        "no marker of the bundle was seen in 100 frames, but {} other names: is it the right bundle, and "
        "tracker.subject right?",
        names);
  });
  runtime.reload_on_hangup([&options] { return load_config(options); },
                           [&config](const config::DaemonConfig& wanted) { log_reload(config, wanted); },
                           [](const std::string& reason) { spdlog::error("{}", reason); });
  for (const std::string& refused : runtime.prefer_realtime()) spdlog::warn("{}", refused);
  std::printf("listening tracker=%u clients=%u", unsigned{runtime.tracker_port()}, unsigned{runtime.client_port()});
  if (const auto port = runtime.metrics_port()) std::printf(" metrics=%u", unsigned{*port});
  std::printf("\n");
  std::fflush(stdout);
  spdlog::info("{}: {} nodes, {} tetrahedra, {} markers, {} pads, {} targets, simulator {}", simulator.scene().name,
               simulator.scene().mesh.node_count(), simulator.scene().mesh.tet_count(),
               simulator.scene().markers.size(), simulator.scene().pads.size(), simulator.scene().targets.size(),
               config.simulator.kind);
  runtime.run();
  log_summary(runtime, simulator);
  spdlog::shutdown();
  return 0;
}

int start(const StartOptions& options) {
  if (options.print_schema) {
    std::printf("%.*s", static_cast<int>(config::config_schema().size()), config::config_schema().data());
    return std::fflush(stdout) == 0 ? 0 : kRefusedByMachine;
  }
  const config::DaemonConfig config = load_config(options);
  if (options.check) {
    start_logging_to_stderr(config.log.level);
  } else {
    start_logging(config);
  }
  const auto simulator = core::make_simulator(load_scene(config.bundle), config.simulator);
  if (!options.check) return serve(config, *simulator, options);
  Counters counters;
  const FrameProcessor processor(*simulator, config, counters);  // asks what only a start would ask
  const core::Scene& scene = simulator->scene();
  std::printf("%s: ok: %s, %d nodes, %d tetrahedra, %zu markers, %zu pads, %zu targets\n", config.source.c_str(),
              scene.name.c_str(), scene.mesh.node_count(), scene.mesh.tet_count(), scene.markers.size(),
              scene.pads.size(), scene.targets.size());
  return 0;
}

int fail(const std::exception& error, int code) {
  std::fprintf(stderr, "tissued: %s\n", error.what());
  return code;
}

}  // namespace
}  // namespace tissued::daemon

int main(int argc, char** argv) {
  using namespace tissued;
  CLI::App app("Tells where the inside of soft tissue is while only its skin markers are seen.", "tissued");
  daemon::StartOptions options;
  daemon::declare_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : daemon::kRefusedInput;
  }
  try {
    return daemon::start(options);
  } catch (const config::ConfigError& error) {
    return daemon::fail(error, daemon::kRefusedInput);
  } catch (const protocol::FileError& error) {
    return daemon::fail(error, daemon::kRefusedInput);
  } catch (const core::ModelError& error) {
    return daemon::fail(error, daemon::kRefusedInput);
  } catch (const std::exception& error) {
    return daemon::fail(error, daemon::kRefusedByMachine);
  }
}
