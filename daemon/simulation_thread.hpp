#pragma once

#include <pthread.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "daemon/answer.hpp"
#include "daemon/counters.hpp"
#include "daemon/frame_processor.hpp"
#include "daemon/latest_value.hpp"
#include "daemon/overload_rule.hpp"
#include "daemon/session_recorder.hpp"
#include "daemon/wake_up.hpp"
#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

/// Steps the simulator on a thread of its own: sleeps until a tracker frame or a request is there, takes the newest
/// frame, publishes the answer, and tells the I/O thread. All hand-overs are wait-free; the I/O thread is the writer of
/// frames and the only reader of answers and mesh.
class SimulationThread {
 public:
  /// Starts the thread; answer() is the one at rest until a frame has been stepped. on_published is called there
  /// whenever an answer or a mesh has been published: it must neither block nor throw. processor and counters must
  /// outlive this.
  /// iterations: of a step as configured. recorder: null, or what is told every answer; outlives this, too.
  SimulationThread(FrameProcessor& processor, int node_count, int iterations, Counters& counters,
                   std::function<void()> on_published, SessionRecorder* recorder = nullptr);
  /// Ends the thread after the step at hand.
  ~SimulationThread() { stop(); }
  SimulationThread(const SimulationThread&) = delete;
  SimulationThread& operator=(const SimulationThread&) = delete;

  void stop();
  /// For the scheduler.
  pthread_t native_handle() { return thread_.native_handle(); }
  /// From any thread: when the step at hand began, monotonic clock; 0 between steps.
  std::uint64_t step_began_ns() const noexcept { return step_began_ns_.load(std::memory_order_relaxed); }
  /// I/O thread: ends the step at hand if it began before `began_before_ns`; the simulator has a few iterations' time
  /// to notice. Returns when that step began, 0 between steps.
  std::uint64_t brake_step(std::uint64_t began_before_ns) noexcept;

  /// I/O thread: hands on a frame; one that was not taken yet is counted as skipped.
  void submit(const protocol::TrackerFrame& frame) noexcept;
  /// I/O thread: asks for one mesh, of the state after the step at hand.
  void request_mesh() noexcept;

  /// I/O thread: whether there is a newer answer, which answer() returns from then on.
  bool fetch_answer() noexcept { return answers_.fetch(); }
  const Answer& answer() const { return answers_.front(); }
  bool fetch_mesh() noexcept { return meshes_.fetch(); }
  const MeshSnapshot& mesh() const { return meshes_.front(); }

 private:
  void run() noexcept;
  void step() noexcept;
  void publish_answer() noexcept;
  void publish_mesh() noexcept;

  FrameProcessor& processor_;
  Counters& counters_;
  std::function<void()> on_published_;
  SessionRecorder* recorder_;
  LatestValue<protocol::TrackerFrame> frames_;
  LatestValue<Answer> answers_;
  LatestValue<MeshSnapshot> meshes_;
  WakeUp wake_up_;
  std::atomic<bool> mesh_requested_{false};
  bool mesh_due_ = false;  // the simulation thread's own: requested, and not published yet
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> step_began_ns_{0};  // also the step's number: no two begin at once
  std::atomic<std::uint64_t> braked_step_{0};
  OverloadRule overload_;
  Answer newest_;    // the simulation thread's own
  Answer previous_;  // the same, one step earlier
  std::thread thread_;
};

}  // namespace tissued::daemon
