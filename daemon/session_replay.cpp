#include "daemon/session_replay.hpp"

#include <bit>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "config/daemon_config.hpp"
#include "core/simulator.hpp"
#include "daemon/answer_messages.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/frame_joiner.hpp"
#include "daemon/frame_processor.hpp"
#include "daemon/recorded_config.hpp"
#include "daemon/recording_reader.hpp"
#include "daemon/scene_loader.hpp"
#include "protocol/session_file.hpp"

namespace tissued::daemon {
namespace {

using protocol::SessionRecordKind;

struct RecordedStep {
  std::uint64_t receive_ns;
  protocol::AnswerSummary answer;
};

struct RecordedRun {
  std::vector<protocol::SessionRecord> arrivals;  // datagrams and deadlines, in order
  std::vector<RecordedStep> steps;
};

RecordedRun read_run(RecordingReader& reader, ReplayReport& report) {
  RecordedRun run;
  while (const auto record = reader.next()) {
    switch (record->kind) {
      case SessionRecordKind::tracker_datagram:
      case SessionRecordKind::deadline:
        run.arrivals.push_back(*record);
        break;
      case SessionRecordKind::answer:
        if (const auto answer = protocol::read_answer_summary(record->body))
          run.steps.push_back({record->stamp_ns, *answer});
        break;
      case SessionRecordKind::lost:
        report.lost += protocol::read_number(record->body).value_or(0);
        break;
      case SessionRecordKind::end:
        report.recorded_hash = protocol::read_number(record->body);
        break;
      case SessionRecordKind::client_datagram:
      case SessionRecordKind::configuration:
      case SessionRecordKind::part:
        break;
    }
  }
  report.damaged_bytes = reader.damaged_bytes();
  report.torn = reader.torn();
  return run;
}

// In words, what an answer differs in; nothing where every bit is as it was. How long a step took says nothing.
std::string difference_of(const protocol::AnswerSummary& then, const protocol::AnswerSummary& now) {
  const auto differs = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) != std::bit_cast<std::uint64_t>(b);
  };
  constexpr auto kDeadline = static_cast<unsigned>(protocol::ValidityReason::kDeadlineMissed);
  if (now.tracker_frame != then.tracker_frame) return "it is about another frame";
  if (((now.reasons ^ then.reasons) & ~kDeadline) != 0) return "its reasons";
  if (now.iterations != then.iterations) return "its iterations";
  if (now.markers_used != then.markers_used || now.markers_seen != then.markers_seen) return "its markers";
  if (differs(now.innovation_rms, then.innovation_rms)) return "its innovation";
  if (differs(now.alarm.level, then.alarm.level) || now.alarm.raised != then.alarm.raised) return "its alarm";
  if (now.targets.size() != then.targets.size()) return "its number of targets";
  for (std::size_t t = 0; t < then.targets.size(); ++t)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (differs(now.targets[t][axis], then.targets[t][axis]))
        return "target " + std::to_string(t) + ": " + std::to_string(now.targets[t][axis] - then.targets[t][axis]) +
               " mm";
  return {};
}

// Steps the frames that were stepped then; those between them were skipped.
class Repetition {
 public:
  using OnStep = std::function<void(std::size_t, std::size_t)>;

  Repetition(const config::DaemonConfig& config, const std::vector<RecordedStep>& steps, const OnStep& on_step,
             ReplayReport& report)
      : simulator_(core::make_simulator(load_scene(config.bundle), config.simulator)),
        processor_(*simulator_, config, counters_),
        steps_(steps),
        on_step_(on_step),
        report_(report) {
    processor_.rest_answer(answer_);
  }

  void offer(std::span<const protocol::TrackerFrame> frames) {
    for (const protocol::TrackerFrame& frame : frames) {
      ++report_.frames;
      if (report_.steps < steps_.size() && is_of(steps_[report_.steps], frame)) step(frame);
    }
  }

  void finish() {
    if (report_.steps < steps_.size())
      throw std::runtime_error("frame " + std::to_string(steps_[report_.steps].answer.stepped_frame) +
                               " was stepped, but not all of its datagrams were recorded");
    report_.state_hash = simulator_->state_hash();
  }

 private:
  static bool is_of(const RecordedStep& recorded, const protocol::TrackerFrame& frame) {
    return frame.frame_number == recorded.answer.stepped_frame && frame.receive_ns == recorded.receive_ns;
  }

  // What only the clock had decided.
  static StepTerms terms_of(const protocol::AnswerSummary& then) {
    static constexpr std::uint64_t kStep = 1;
    static const std::atomic<std::uint64_t> pulled{kStep};
    StepTerms terms;
    if (then.reasons & protocol::ValidityReason::kOverloaded) {
      terms.overload = 1;
      terms.max_iterations = then.iterations;
    }
    if (then.reasons & protocol::ValidityReason::kStepBraked) terms.brake = {&pulled, kStep};
    return terms;
  }

  void step(const protocol::TrackerFrame& frame) {
    const protocol::AnswerSummary& then = steps_[report_.steps].answer;
    previous_ = answer_;
    processor_.process(frame, previous_, answer_, terms_of(then));
    const std::string difference = difference_of(then, answer_summary(frame.frame_number, answer_));
    ++report_.steps;
    if (difference.empty()) {
      ++report_.equal;
    } else if (!report_.first_unequal) {
      report_.first_unequal = then.stepped_frame;
      report_.difference = difference;
    }
    on_step_(report_.steps, steps_.size());
  }

  Counters counters_;
  std::unique_ptr<core::Simulator> simulator_;
  FrameProcessor processor_;
  const std::vector<RecordedStep>& steps_;
  const OnStep& on_step_;
  ReplayReport& report_;
  Answer answer_, previous_;
};

}  // namespace

ReplayReport replay_session(const std::filesystem::path& file, const std::filesystem::path& bundle,
                            const std::function<void(std::size_t, std::size_t)>& on_step) {
  RecordingReader reader(file);
  ReplayReport report;
  const RecordedRun run = read_run(reader, report);
  config::DaemonConfig config = recorded_config(reader, file, bundle);
  apply_model(config);
  Repetition repetition(config, run.steps, on_step, report);
  FrameJoiner joiner(config);
  for (const protocol::SessionRecord& arrival : run.arrivals)
    repetition.offer(arrival.kind == SessionRecordKind::deadline ? joiner.flush_if_due(arrival.stamp_ns)
                                                                 : joiner.add(arrival.body, arrival.stamp_ns));
  repetition.finish();
  return report;
}

}  // namespace tissued::daemon
