#include "daemon/runtime.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <system_error>
#include <utility>

#include "daemon/monotonic_clock.hpp"
#include "daemon/realtime.hpp"

namespace tissued::daemon {

namespace {

// Of a step, before it is ended, where steps take less than a quarter of it: see StepWatch. `fem` is for judging, and
// slow.
constexpr std::uint64_t kLongestStep_ns = 80'000'000;

std::unique_ptr<SessionRecorder> make_recorder(const config::DaemonConfig& config, Counters& counters,
                                               std::function<void(const std::string&)> on_failure) {
  if (config.record.empty()) return nullptr;
  protocol::SessionHeader header;
  header.wall_ns = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count());
  header.monotonic_ns = monotonic_ns();
  header.bundle_hash = hash_of_bundle(config.bundle);
  const std::string name = config.bundle.scene.name.substr(0, protocol::Name::kCapacity);
  header.scene = protocol::Name::from(name).value_or(*protocol::Name::from("?"));
  header.bundle = std::filesystem::absolute(config.bundle.folder).string();
  // A daemon that is started again by its watchdog must neither write over what it recorded nor stay down for it.
  std::error_code ignored;  // what is wrong with the folder is said when the file cannot be created
  if (config.record.has_parent_path()) std::filesystem::create_directories(config.record.parent_path(), ignored);
  const std::filesystem::path file = free_recording(config.record);
  if (file != config.record && on_failure)
    on_failure(config.record.string() + ": exists; recording to " + file.string());
  try {
    return std::make_unique<SessionRecorder>(file, config.record_max_bytes, header, config.document, counters,
                                             on_failure);
  } catch (const std::system_error& error) {
    if (error.code().value() != ENOSPC && error.code().value() != EDQUOT) throw;
    counters.set(Count::recording_failed, 1);
    if (on_failure) on_failure(std::string(error.what()) + "; nothing is recorded");
    return nullptr;
  }
}

}  // namespace

Runtime::Runtime(const config::DaemonConfig& config, core::Simulator& simulator,
                 std::function<void(const std::string&)> on_recording_failed)
    : simulator_(simulator),
      realtime_(config.realtime),
      key_file_(config.key_file),
      recorder_(make_recorder(config, counters_, std::move(on_recording_failed))),
      processor_(simulator, config, counters_),
      simulation_(
          processor_, simulator.scene().mesh.node_count(), config.simulator.solver.iterations, counters_,
          [this] { published_.notify(); }, recorder_.get()),
      step_watch_(context_, simulation_, config.simulator.kind == "fem" ? 0 : kLongestStep_ns),
      receiver_(
          context_, config, counters_,
          [this](const protocol::TrackerFrame& frame) {
            simulation_.submit(frame);
            step_watch_.on_submitted();
          },
          recorder_.get()),
      server_(
          context_, config, simulator.scene(), simulation_, counters_,
          [this] { return receiver_.rate_hz(monotonic_ns()); }, recorder_.get()),
      published_watch_(context_, published_.descriptor()),
      signals_(context_) {
  if (config.metrics.port)
    metrics_.emplace(context_, *config.metrics.port, [this] { return server_.answers().metrics(); });
  if (ServiceManager::listens()) {
    service_.emplace(context_, simulation_, [this](std::uint64_t now_ns) { return server_.answers().status(now_ns); });
  }
}

Runtime::~Runtime() {
  simulation_.stop();
  published_watch_.release();  // the descriptor is published_'s own
}

void Runtime::run() {
  watch_simulation();
  receiver_.start();
  server_.start();
  if (metrics_) metrics_->start();
  if (service_) service_->start();
  context_.run();
  if (service_) service_->stop();
  simulation_.stop();
  receiver_.close();
  server_.close();
  if (metrics_) metrics_->close();
  if (recorder_) recorder_->stop(simulator_.state_hash());
}

std::vector<std::string> Runtime::prefer_realtime() {
  std::vector<std::string> refusals;
  const auto note = [&](std::optional<std::string> refused) {
    if (refused) refusals.push_back(std::move(*refused));
  };
  if (!realtime_.enabled) return refusals;
  const pthread_t simulation = simulation_.native_handle(), serving = ::pthread_self();
  note(schedule_realtime("the simulation", simulation, kSimulationPriority));
  note(schedule_realtime("the sockets", serving, kServingPriority));
  if (realtime_.simulation_cpu) note(pin_to_cpu("the simulation is", simulation, *realtime_.simulation_cpu));
  if (realtime_.io_cpu) note(pin_to_cpu("the sockets are", serving, *realtime_.io_cpu));
  note(lock_memory());
  return refusals;
}

void Runtime::stop_on_signals() {
  signals_.add(SIGINT);
  signals_.add(SIGTERM);
  signals_.async_wait([this](const boost::system::error_code& error, int) {
    if (!error) stop();
  });
}

void Runtime::reload_on_hangup(std::function<config::DaemonConfig()> load,
                               std::function<void(const config::DaemonConfig&)> on_reloaded,
                               std::function<void(const std::string&)> on_refused) {
  Reload::Hooks hooks;
  if (!key_file_.empty()) hooks.load_keys = [file = key_file_] { return config::read_key_file(file); };
  hooks.load = std::move(load);
  hooks.use_keys = [this](const Reload::Keys& keys) {
    receiver_.use(keys);
    server_.use(keys);
  };
  hooks.apply = [this, told = std::move(on_reloaded)](const config::DaemonConfig& config) {
    receiver_.apply(config);
    server_.apply(config);
    told(config);
  };
  hooks.refuse = std::move(on_refused);
  reload_.emplace(context_, std::move(hooks));
}

void Runtime::watch_simulation() {
  using Descriptor = boost::asio::posix::stream_descriptor;
  published_watch_.async_wait(Descriptor::wait_read, [this](const boost::system::error_code& error) {
    if (error) return;
    published_.drain();
    if (server_.on_published()) step_watch_.on_answered(simulation_.answer());
    watch_alarm();
    watch_names();
    watch_simulation();
  });
}

void Runtime::watch_alarm() {
  const AlarmAnswer& alarm = simulation_.answer().alarm;
  if (alarm.raised == alarm_raised_) return;
  alarm_raised_ = alarm.raised;
  if (on_alarm_) on_alarm_(alarm);
}

// A tracker of another body, or that calls it otherwise, is like one that sees nothing.
void Runtime::watch_names() {
  constexpr std::uint64_t kFrames = 100;
  marker_seen_ = marker_seen_ || simulation_.answer().markers_seen > 0;
  if (!on_strangers_ || marker_seen_ || counters_[Count::frames_stepped] < kFrames) return;
  const std::uint64_t strangers = counters_[Count::unknown_names];
  if (strangers > 0) std::exchange(on_strangers_, nullptr)(strangers);
}

}  // namespace tissued::daemon
