#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {

/// All that a daemon says at one frame about its targets, its parts joined.
struct TargetAnswer {
  protocol::Predictions frame;                      ///< the scalars; its own lists hold the last part only
  std::vector<protocol::TargetPrediction> targets;  ///< (targets) ascending by index
  std::vector<protocol::PadReaction> pads;          ///< (pads in contact) ascending by index
  std::uint64_t receive_ns = 0;                     ///< our monotonic clock, when the last part came
};

/// Joins the parts of predictions; frames that miss a part are given up when a newer one begins.
class AnswerJoiner {
 public:
  /// The answer that this part completes, or nullopt.
  std::optional<TargetAnswer> add(const protocol::Predictions& part, std::uint64_t receive_ns);

 private:
  TargetAnswer answer_;
  std::uint64_t parts_seen_ = 0;  // bit k: part k of answer_.frame is in
};

}  // namespace tissued::daemon
