#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <cstdint>
#include <system_error>

#include "config/daemon_config.hpp"
#include "core/simulator.hpp"
#include "daemon/client_server.hpp"
#include "daemon/counters.hpp"
#include "daemon/event_fd.hpp"
#include "daemon/frame_processor.hpp"
#include "daemon/simulation_thread.hpp"
#include "daemon/tracker_receiver.hpp"

namespace tissued::daemon {

/// The daemon: sockets on the thread that calls run(), the simulation on one of its own.
class Runtime {
 public:
  /// Binds both sockets; the simulator must outlive the runtime and have the config's scene, with its mesh.
  /// Throws BindError, core::ModelError, std::system_error.
  Runtime(const config::DaemonConfig& config, core::Simulator& simulator);
  ~Runtime();
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

  std::uint16_t tracker_port() const { return receiver_.port(); }
  std::uint16_t client_port() const { return server_.port(); }

  /// Serves until stop(); then both threads are at rest and the sockets closed.
  void run();
  /// From any thread; before run() as well.
  void stop() { context_.stop(); }
  /// Real-time scheduling for the simulation and for the calling thread, which is to be the one that calls run(), and
  /// memory that stays; says what the kernel refused. Before run().
  std::error_code prefer_realtime() noexcept;
  /// Makes SIGINT and SIGTERM stop.
  void stop_on_signals();

  const Counters& counters() const { return counters_; }
  /// After run() only.
  const ClientServer& server() const { return server_; }

 private:
  void watch_simulation();

  boost::asio::io_context context_{1};  // one thread runs it
  Counters counters_;
  EventFd published_;
  FrameProcessor processor_;
  SimulationThread simulation_;
  TrackerReceiver receiver_;
  ClientServer server_;
  boost::asio::posix::stream_descriptor published_watch_;
  boost::asio::signal_set signals_;
};

}  // namespace tissued::daemon
