#include "daemon/trial_player.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <thread>

#include "daemon/monotonic_clock.hpp"
#include "daemon/pacing.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kGrace_ns = 300'000'000;  // for answers after the last frame
constexpr std::uint64_t kGlance_ns = 50'000'000;  // how often a waiting receiver looks up
constexpr double kFrameRounding = 1e-6;           // s, of sums of frame periods
constexpr std::uint64_t kRunUp_ns = 20'000'000;   // before the first frame

std::uint64_t to_ns(double seconds) { return static_cast<std::uint64_t>(std::llround(seconds * 1e9)); }

}  // namespace

// Shared by the two threads while a trial runs.
struct TrialPlayer::Progress {
  explicit Progress(std::size_t frames) : sent_ns(frames) {}
  std::vector<std::atomic<std::uint64_t>> sent_ns;  // monotonic clock; 0: not sent yet
  std::atomic<std::size_t> sent{0};
  std::atomic<bool> over{false};
  std::exception_ptr failure;  // read after `over`
};

std::uint64_t TrialPlayer::Schedule::send_ns(std::size_t frame) const {
  return start_ns + to_ns(static_cast<double>(frame) / (rate_hz * speed));
}

std::uint64_t TrialPlayer::Schedule::stamp_ns(std::size_t frame) const {
  return first_stamp_ns + to_ns(static_cast<double>(frame) / rate_hz);
}

std::optional<std::size_t> TrialPlayer::Schedule::frame_of(std::uint64_t stamp) const {
  if (stamp < first_stamp_ns) return std::nullopt;
  const double frame = std::round(static_cast<double>(stamp - first_stamp_ns) * 1e-9 * rate_hz);
  if (frame >= static_cast<double>(total)) return std::nullopt;
  const auto index = static_cast<std::size_t>(frame);
  return stamp_ns(index) == stamp ? std::optional(index) : std::nullopt;
}

TrialPlayer::Schedule TrialPlayer::schedule_for(const Recording& recording) const {
  Schedule schedule{};
  schedule.rate_hz = recording.rate_hz();
  schedule.speed = options_.speed;
  schedule.lead_in = static_cast<std::size_t>(std::llround(options_.lead_in * recording.rate_hz()));
  schedule.total = schedule.lead_in + recording.frame_count();
  schedule.start_ns = std::max(monotonic_ns() + kRunUp_ns, earliest_start_ns_);
  schedule.first_stamp_ns = tracker_clock_ns_;
  return schedule;
}

bool TrialPlayer::finished() const {
  return stop_.requested() || (options_.stop_after > 0.0 && streamed_ >= options_.stop_after - kFrameRounding);
}

PlayedTrial TrialPlayer::play(const Recording& recording) {
  const Schedule schedule = schedule_for(recording);
  Progress progress(schedule.total);
  PlayedTrial played;
  played.lead_in = schedule.lead_in;
  played.answers.resize(schedule.total);

  std::thread sending([&] {
    try {
      send_all(recording, schedule, progress);
    } catch (...) {
      progress.failure = std::current_exception();
    }
    progress.over.store(true, std::memory_order_release);
  });
  receive_all(schedule, progress, played);
  sending.join();
  if (progress.failure) std::rethrow_exception(progress.failure);

  played.sent = progress.sent.load();
  streamed_ += static_cast<double>(played.sent) / (schedule.rate_hz * schedule.speed);
  tracker_clock_ns_ = schedule.stamp_ns(schedule.total) + to_ns(options_.pause);
  earliest_start_ns_ = schedule.send_ns(played.sent) + to_ns(options_.pause);
  return played;
}

void TrialPlayer::send_all(const Recording& recording, const Schedule& schedule, Progress& progress) {
  protocol::TrackerFrame frame;
  const double left = options_.stop_after > 0.0 ? options_.stop_after - streamed_ : INFINITY;  // s
  const double limit = std::round(left * schedule.rate_hz * schedule.speed);                   // frames
  for (std::size_t i = 0; i < schedule.total && !stop_.requested(); ++i) {
    if (static_cast<double>(i) >= limit) return;
    const std::size_t source = i < schedule.lead_in ? i % recording.opening_rest() : i - schedule.lead_in;
    const bool fits = recording.fill(source, options_.items, frame);
    frame.frame_number = static_cast<std::uint32_t>(i + 1);
    frame.stamp_ns = schedule.stamp_ns(i);
    sleep_until_ns(schedule.send_ns(i));
    progress.sent_ns[i].store(monotonic_ns(), std::memory_order_release);
    if (!fits || !sender_.send(frame)) {
      throw std::runtime_error(recording.name() + ": frame " + std::to_string(recording.first_frame() + source) +
                               " does not fit the tracker protocol");
    }
    progress.sent.store(i + 1, std::memory_order_release);
  }
}

void TrialPlayer::receive_all(const Schedule& schedule, Progress& progress, PlayedTrial& played) {
  std::uint64_t give_up_ns = 0;  // known once all is sent
  AnswerJoiner joiner;
  for (;;) {
    const std::uint64_t now = monotonic_ns();
    const bool over = progress.over.load(std::memory_order_acquire);
    if (over && give_up_ns == 0) give_up_ns = now + kGrace_ns;
    if (over && (answers_ == nullptr || played.answered >= progress.sent.load() || now >= give_up_ns)) return;
    if (answers_ == nullptr) {
      sleep_until_ns(now + kGlance_ns);
      continue;
    }
    const auto message = answers_->receive(now + kGlance_ns);
    if (!message) continue;
    const auto* part = std::get_if<protocol::Predictions>(&message->message);
    if (part == nullptr) continue;
    if (const auto answer = joiner.add(*part, message->receive_ns)) take(*answer, schedule, progress, played);
  }
}

void TrialPlayer::take(const TargetAnswer& answer, const Schedule& schedule, const Progress& progress,
                       PlayedTrial& played) {
  if (!answer.frame.has_stamp) return;
  const auto frame = schedule.frame_of(answer.frame.stamp_ns);
  if (!frame || played.answers[*frame]) return;
  ++played.answered;
  played.answers[*frame] =
      FrameAnswer{answer, answer.receive_ns - progress.sent_ns[*frame].load(std::memory_order_acquire)};
}

}  // namespace tissued::daemon
