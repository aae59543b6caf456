#include "daemon/trial_run.hpp"

#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kPause_ns = 1'000'000'000;

core::Vec3 to_vec3(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

RunFrame run_frame(const Answer& answer, const Recording& recording, std::size_t index, double time) {
  RunFrame frame;
  frame.index = index;
  frame.time = time;
  frame.contact = !answer.pads.empty();
  frame.diverged = (answer.reasons & protocol::ValidityReason::kDiverged) != 0;
  frame.iterations = answer.report.iterations;
  frame.markers_used = answer.report.markers_used;
  frame.innovation_rms = answer.report.innovation_rms;
  frame.step_time_ns = answer.step_time_ns;
  frame.alarm = answer.alarm;
  for (std::size_t t = 0; t < answer.targets.size(); ++t) {
    const TargetPlace& target = answer.targets[t];
    frame.targets.push_back({to_vec3(target.position), target.covariance, recording.target(index, t)});
  }
  return frame;
}

}  // namespace

std::vector<std::size_t> recorded_order(const Recording& recording) {
  std::vector<std::size_t> order(recording.frame_count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

std::vector<std::size_t> jump_order(const Recording& recording, std::size_t count) {
  const auto& hold = recording.hold();
  std::vector<std::size_t> order;
  if (hold.empty()) return order;
  for (std::size_t i = 0; i < recording.opening_rest(); ++i) order.push_back(i);
  for (std::size_t i = 0; i < count; ++i) order.push_back(hold[i % hold.size()]);
  return order;
}

TrialRunner::TrialRunner(const config::DaemonConfig& config, const core::Scene& scene, bool pad_forces)
    : simulator_(core::make_simulator(scene, config.simulator)),
      processor_(std::make_unique<FrameProcessor>(*simulator_, config, counters_)),
      frame_(std::make_unique<protocol::TrackerFrame>()),
      items_{.pad_forces = pad_forces, .truth = false},
      begin_ns_(kPause_ns) {
  processor_->rest_answer(answer_);
}

TrialRun TrialRunner::run(const Recording& recording, std::span<const std::size_t> order) {
  TrialRun run;
  for (const std::size_t index : order) {
    if (!recording.fill(index, items_, *frame_)) {
      throw std::runtime_error(recording.name() + ": more items in a frame than a tracker frame holds");
    }
    const double time = static_cast<double>(run.size()) / recording.rate_hz();
    frame_->frame_number = ++frames_;
    frame_->stamp_ns = begin_ns_ + static_cast<std::uint64_t>(std::llround(time * 1e9));
    frame_->receive_ns = *frame_->stamp_ns;
    const Answer previous = answer_;
    processor_->process(*frame_, previous, answer_);
    run.push_back(run_frame(answer_, recording, index, time));
  }
  if (frame_->stamp_ns) begin_ns_ = *frame_->stamp_ns + kPause_ns;
  return run;
}

TrialRun run_trial(const config::DaemonConfig& config, const core::Scene& scene, const Recording& recording,
                   std::span<const std::size_t> order, bool pad_forces) {
  return TrialRunner(config, scene, pad_forces).run(recording, order);
}

}  // namespace tissued::daemon
