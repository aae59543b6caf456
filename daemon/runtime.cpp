#include "daemon/runtime.hpp"

#include <csignal>

#include "daemon/monotonic_clock.hpp"
#include "daemon/realtime.hpp"

namespace tissued::daemon {

Runtime::Runtime(const config::DaemonConfig& config, core::Simulator& simulator)
    : processor_(simulator, config, counters_),
      simulation_(processor_, simulator.scene().mesh.node_count(), counters_, [this] { published_.notify(); }),
      receiver_(context_, config, counters_,
                [this](const protocol::TrackerFrame& frame) { simulation_.submit(frame); }),
      server_(context_, config, simulator.scene(), simulation_, counters_,
              [this] { return receiver_.rate_hz(monotonic_ns()); }),
      published_watch_(context_, published_.descriptor()),
      signals_(context_) {}

Runtime::~Runtime() {
  simulation_.stop();
  published_watch_.release();  // the descriptor is published_'s own
}

void Runtime::run() {
  watch_simulation();
  receiver_.start();
  server_.start();
  context_.run();
  simulation_.stop();
  receiver_.close();
  server_.close();
}

std::error_code Runtime::prefer_realtime() noexcept {
  if (const auto refused = simulation_.prefer_realtime()) return refused;
  if (const auto refused = schedule_realtime(::pthread_self(), kServingPriority)) return refused;
  return lock_memory();
}

void Runtime::stop_on_signals() {
  signals_.add(SIGINT);
  signals_.add(SIGTERM);
  signals_.async_wait([this](const boost::system::error_code& error, int) {
    if (!error) stop();
  });
}

void Runtime::watch_simulation() {
  using Descriptor = boost::asio::posix::stream_descriptor;
  published_watch_.async_wait(Descriptor::wait_read, [this](const boost::system::error_code& error) {
    if (error) return;
    published_.drain();
    server_.on_published();
    watch_simulation();
  });
}

}  // namespace tissued::daemon
