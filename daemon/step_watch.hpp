#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>

#include "daemon/handler_memory.hpp"
#include "daemon/simulation_thread.hpp"

namespace tissued::daemon {

/// Notices a step that does not end, and has it ended: the daemon then holds the last good answer and goes on from the
/// last good state. Without a step there is nothing to watch, and no wake-up. What is too long for one body is not for
/// a larger one: steps that were done give the next ones four times their time, and every one that was ended twice as
/// much.
class StepWatch {
 public:
  /// References must outlive this. longest_ns: of a step of a body that takes less than a quarter of it; 0: however
  /// long.
  StepWatch(boost::asio::io_context& context, SimulationThread& simulation, std::uint64_t longest_ns)
      : timer_(context), simulation_(simulation), least_ns_(longest_ns), longest_ns_(longest_ns) {}

  /// A frame was handed to the simulation.
  void on_submitted();
  void on_answered(const Answer& answer);

 private:
  void look_in(std::uint64_t wait_ns);
  void look();

  HandlerMemory memory_;
  boost::asio::steady_timer timer_;
  SimulationThread& simulation_;
  std::uint64_t least_ns_;    // that a step is given
  std::uint64_t longest_ns_;  // of the next one
  bool watching_ = false;
};

}  // namespace tissued::daemon
