#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/daemon_config.hpp"
#include "core/simulator.hpp"
#include "daemon/client_server.hpp"
#include "daemon/counters.hpp"
#include "daemon/event_fd.hpp"
#include "daemon/frame_processor.hpp"
#include "daemon/metrics_server.hpp"
#include "daemon/reload.hpp"
#include "daemon/service_manager.hpp"
#include "daemon/session_recorder.hpp"
#include "daemon/simulation_thread.hpp"
#include "daemon/step_watch.hpp"
#include "daemon/tracker_receiver.hpp"

namespace tissued::daemon {

/// The daemon: sockets on the thread that calls run(), the simulation on one of its own.
class Runtime {
 public:
  /// Binds all sockets; the simulator must outlive the runtime and have the config's scene, with its mesh.
  /// Where the configuration asks for a recording, its file is created, under another name where that is taken; that,
  /// and when recording ends early or cannot begin for want of space, on_recording_failed is told with one line, in the
  /// end on a thread of its own.
  /// Where a service manager has started the process, it is told how the daemon is doing, see ServiceManager.
  /// Throws BindError, core::ModelError, protocol::FileError, std::runtime_error.
  Runtime(const config::DaemonConfig& config, core::Simulator& simulator,
          std::function<void(const std::string&)> on_recording_failed = {});
  ~Runtime();
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  std::uint16_t tracker_port() const { return receiver_.port(); }
  std::uint16_t client_port() const { return server_.port(); }
  /// Nothing where the configuration wants no metrics.
  std::optional<std::uint16_t> metrics_port() const {
    return metrics_ ? std::optional(metrics_->port()) : std::nullopt;
  }

  /// Serves until stop(); then both threads are at rest and the sockets closed.
  void run();
  /// From any thread; before run() as well.
  void stop() { context_.stop(); }
  /// Where the configuration asks for it: real-time scheduling and CPUs for the simulation and for the calling thread,
  /// which is to be the one that calls run(), and memory that stays. A line for each thing that the kernel refused,
  /// see realtime.hpp. Before run().
  std::vector<std::string> prefer_realtime();
  /// Called on the thread of run() when the alarm is raised and when it clears; must not block. Before run().
  void on_alarm(std::function<void(const AlarmAnswer&)> callback) { on_alarm_ = std::move(callback); }
  /// Called once, on the thread of run(), where a hundred frames have come and not one name in them is a marker of the
  /// scene, with how many names were passed over; must not block. Before run().
  void on_strangers(std::function<void(std::uint64_t)> callback) { on_strangers_ = std::move(callback); }
  /// Makes SIGINT and SIGTERM stop.
  void stop_on_signals();
  /// Makes SIGHUP read the keys and, by `load`, the configuration again, while everything goes on, and take on what a
  /// running daemon can, see Reload. What became of it is told on the thread of run(). Before run().
  void reload_on_hangup(std::function<config::DaemonConfig()> load,
                        std::function<void(const config::DaemonConfig&)> on_reloaded,
                        std::function<void(const std::string&)> on_refused);

  const Counters& counters() const { return counters_; }
  /// After run() only.
  const ClientServer& server() const { return server_; }

 private:
  void watch_simulation();
  void watch_alarm();
  void watch_names();

  core::Simulator& simulator_;
  config::RealtimeConfig realtime_;
  std::filesystem::path key_file_;
  boost::asio::io_context context_{1};  // one thread runs it
  Counters counters_;
  EventFd published_;
  std::unique_ptr<SessionRecorder> recorder_;  // null: nothing is recorded
  FrameProcessor processor_;
  SimulationThread simulation_;
  StepWatch step_watch_;
  TrackerReceiver receiver_;
  ClientServer server_;
  std::optional<MetricsServer> metrics_;
  std::optional<ServiceManager> service_;  // nothing: nobody wants to be told
  boost::asio::posix::stream_descriptor published_watch_;
  boost::asio::signal_set signals_;
  std::function<void(const AlarmAnswer&)> on_alarm_;
  bool alarm_raised_ = false;
  std::function<void(std::uint64_t)> on_strangers_;  // null: told, or nobody wants to be
  bool marker_seen_ = false;
  std::optional<Reload> reload_;  // last: its thread speaks to the context
};

}  // namespace tissued::daemon
