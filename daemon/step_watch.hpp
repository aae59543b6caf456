#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>

#include "daemon/handler_memory.hpp"
#include "daemon/simulation_thread.hpp"

namespace tissued::daemon {

/// Notices a step that does not end, and has it ended: the daemon then holds the last good answer and goes on from the
/// last good state. Without a step there is nothing to watch, and no wake-up.
class StepWatch {
 public:
  /// References must outlive this. longest_ns: of a step; 0: however long.
  StepWatch(boost::asio::io_context& context, SimulationThread& simulation, std::uint64_t longest_ns)
      : timer_(context), simulation_(simulation), longest_ns_(longest_ns) {}

  /// A frame was handed to the simulation.
  void on_submitted();

 private:
  void look_in(std::uint64_t wait_ns);
  void look();

  HandlerMemory memory_;
  boost::asio::steady_timer timer_;
  SimulationThread& simulation_;
  std::uint64_t longest_ns_;
  bool watching_ = false;
};

}  // namespace tissued::daemon
