#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/probe_messages.hpp"

namespace tissued::daemon {

/// All that a daemon says at one frame about one probe, its parts joined.
struct JoinedView {
  protocol::ProbeView frame;                   ///< the scalars; its own list holds the last part only
  std::vector<protocol::ImageTarget> targets;  ///< ascending by index
};

/// Joins the parts of probe views; frames that miss a part are given up when a newer one begins.
class ViewJoiner {
 public:
  /// The views of every probe, ascending by index, that this part completes, or nullopt.
  std::optional<std::vector<JoinedView>> add(const protocol::ProbeView& part);

 private:
  struct Progress {
    JoinedView view;
    std::uint64_t parts_seen = 0;  // bit k: part k is in
    bool complete() const;
  };
  std::vector<Progress> probes_;  // (probes)
  std::uint32_t tracker_frame_ = 0;
  std::uint64_t receive_ns_ = 0;
};

}  // namespace tissued::daemon
