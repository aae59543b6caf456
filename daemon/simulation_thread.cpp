#include "daemon/simulation_thread.hpp"

#include <pthread.h>

#include <utility>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {

SimulationThread::SimulationThread(FrameProcessor& processor, int node_count, int iterations, Counters& counters,
                                   std::function<void()> on_published, SessionRecorder* recorder)
    : processor_(processor),
      counters_(counters),
      on_published_(std::move(on_published)),
      recorder_(recorder),
      meshes_(node_count),
      overload_(iterations) {
  // The answer at rest is there from the start; the thread is not yet, so that both ends of the slot are ours.
  processor_.rest_answer(newest_);
  answers_.back() = newest_;
  answers_.publish();
  answers_.fetch();
  thread_ = std::thread([this] { run(); });
  ::pthread_setname_np(thread_.native_handle(), "simulation");
}

void SimulationThread::stop() {
  if (!thread_.joinable()) return;
  stopping_.store(true, std::memory_order_release);
  wake_up_.notify();
  thread_.join();
}

void SimulationThread::submit(const protocol::TrackerFrame& frame) noexcept {
  frames_.back() = frame;
  if (frames_.publish()) counters_.add(Count::frames_skipped);
  wake_up_.notify();
}

std::uint64_t SimulationThread::brake_step(std::uint64_t began_before_ns) noexcept {
  const std::uint64_t began_ns = step_began_ns();
  if (began_ns != 0 && began_ns < began_before_ns) braked_step_.store(began_ns, std::memory_order_relaxed);
  return began_ns;
}

void SimulationThread::request_mesh() noexcept {
  if (!mesh_requested_.exchange(true, std::memory_order_acq_rel)) wake_up_.notify();
}

void SimulationThread::run() noexcept {
  for (;;) {
    const auto ticket = wake_up_.ticket();
    if (stopping_.load(std::memory_order_acquire)) return;
    if (frames_.fetch()) {
      step();
    } else if (!mesh_requested_.load(std::memory_order_acquire)) {
      wake_up_.wait(ticket);
      continue;
    }
    if (mesh_requested_.exchange(false, std::memory_order_acq_rel)) mesh_due_ = true;
    if (mesh_due_) publish_mesh();
  }
}

void SimulationThread::step() noexcept {
  const std::uint64_t began_ns = monotonic_ns();
  step_began_ns_.store(began_ns, std::memory_order_relaxed);
  previous_ = newest_;
  processor_.process(frames_.front(), previous_, newest_,
                     {overload_.level(), overload_.max_iterations(), {&braked_step_, began_ns}});
  overload_.note(1e-9 * static_cast<double>(newest_.step_time_ns), processor_.frame_interval());
  publish_answer();
  if (recorder_ != nullptr) recorder_->add_answer(frames_.front(), newest_);
  step_began_ns_.store(0, std::memory_order_relaxed);
}

void SimulationThread::publish_answer() noexcept {
  answers_.back() = newest_;
  if (answers_.publish()) counters_.add(Count::answers_unseen);
  on_published_();
}

void SimulationThread::publish_mesh() noexcept {
  if (!processor_.snapshot(newest_, meshes_.back())) return;  // after the next step that gives an answer
  mesh_due_ = false;
  meshes_.publish();
  on_published_();
}

}  // namespace tissued::daemon
