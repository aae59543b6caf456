#include "daemon/watch_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "daemon/confidence.hpp"

namespace tissued::daemon {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t kRateWindow_ns = 2'000'000'000;
constexpr std::uint32_t kLongestGap = 100'000;  // frames; a longer jump is another numbering

}  // namespace

void WatchStatistics::introduce(const protocol::HelloReply& hello, const std::vector<std::string>& targets,
                                const std::vector<std::string>& pads) {
  hello_ = hello;
  pad_names_ = pads;
  latest_.reset();
  last_frame_.reset();
  if (std::ranges::equal(targets_, targets, {}, &WatchedTarget::name)) return;
  targets_.clear();
  for (const std::string& name : targets) targets_.push_back({name, std::nullopt, std::nullopt, {}, {}});
  tick_errors_.assign(targets.size(), kNaN);
}

void WatchStatistics::show(const TargetAnswer& answer) {
  latest_ = answer;
  for (const protocol::TargetPrediction& prediction : answer.targets) {
    if (prediction.index < targets_.size()) targets_[prediction.index].latest = prediction;
  }
}

void WatchStatistics::add_streamed(const TargetAnswer& answer) {
  const bool seen_before = latest_ && latest_->frame.receive_ns == answer.frame.receive_ns;
  show(answer);
  if (seen_before || answer.frame.validity == protocol::Validity::no_data) return;
  ++frames_;
  ++validity_[answer.frame.validity];
  count_frame(answer.frame.tracker_frame);
  arrivals_.push_back(answer.receive_ns);
  const std::uint64_t latency = answer.frame.send_ns - answer.frame.receive_ns;
  recent_latency_.add(latency);
  latency_.add(latency);
  recent_step_.add(answer.frame.step_time_ns);
  step_.add(answer.frame.step_time_ns);
  for (const protocol::TargetPrediction& prediction : answer.targets) {
    if (prediction.index < targets_.size()) judge(targets_[prediction.index], prediction);
  }
}

void WatchStatistics::count_frame(std::uint32_t frame) {
  if (last_frame_) {
    const std::uint32_t ahead = frame - *last_frame_;  // modulo 2^32, as the tracker counts
    if (ahead > kLongestGap) {
      ++restarts_;
    } else if (ahead > 1) {
      lost_ += ahead - 1;
    }
  }
  last_frame_ = frame;
}

void WatchStatistics::judge(WatchedTarget& target, const protocol::TargetPrediction& prediction) {
  const auto error = error_of(prediction);
  if (!error) return;
  target.error = error;
  ErrorStatistics& statistics = target.errors;
  ++statistics.frames;
  statistics.sum += *error;
  statistics.most = std::max(statistics.most, *error);
  double& largest = tick_errors_[prediction.index];
  largest = std::isnan(largest) ? *error : std::max(largest, *error);
  if (const auto inside = inside_95(prediction)) {
    ++statistics.judged;
    statistics.inside += *inside ? 1 : 0;
  }
}

void WatchStatistics::tick(std::uint64_t now_ns) {
  while (!arrivals_.empty() && now_ns - arrivals_.front() > kRateWindow_ns) arrivals_.pop_front();
  if (arrivals_.empty() && recent_latency_.size() > 0) recent_latency_ = recent_step_ = LatencyWindow();
  if (now_ns - tick_ns_ < kTick_ns) return;
  tick_ns_ = now_ns;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    if (std::isnan(tick_errors_[i])) targets_[i].error.reset();
    targets_[i].trace.push_back(tick_errors_[i]);
    if (targets_[i].trace.size() > kTraceLength) targets_[i].trace.pop_front();
    tick_errors_[i] = kNaN;
  }
}

std::uint64_t WatchStatistics::age_ns(std::uint64_t now_ns) const {
  if (!latest_) return 0;
  return latest_->frame.age_ns + (now_ns > latest_->receive_ns ? now_ns - latest_->receive_ns : 0);
}

double WatchStatistics::rate_hz(std::uint64_t now_ns) const {
  if (arrivals_.size() < 2 || now_ns - arrivals_.back() > kRateWindow_ns / 2) return 0.0;
  const double span = static_cast<double>(arrivals_.back() - arrivals_.front()) * 1e-9;
  return span > 0.0 ? static_cast<double>(arrivals_.size() - 1) / span : 0.0;
}

}  // namespace tissued::daemon
