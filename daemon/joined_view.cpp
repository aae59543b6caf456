#include "daemon/joined_view.hpp"

#include <algorithm>

namespace tissued::daemon {

bool ViewJoiner::Progress::complete() const {
  const unsigned parts = view.frame.part_count;
  const std::uint64_t all = parts >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << parts) - 1;
  return parts_seen != 0 && (parts_seen & all) == all;
}

std::optional<std::vector<JoinedView>> ViewJoiner::add(const protocol::ProbeView& part) {
  const bool same_frame =
      probes_.size() == part.probe_count && tracker_frame_ == part.tracker_frame && receive_ns_ == part.receive_ns;
  if (!same_frame) {
    probes_.assign(part.probe_count, Progress{});
    tracker_frame_ = part.tracker_frame;
    receive_ns_ = part.receive_ns;
  }
  Progress& probe = probes_[part.index];
  const std::uint64_t bit = std::uint64_t{1} << (part.part % 64);
  if ((probe.parts_seen & bit) != 0) return std::nullopt;
  probe.parts_seen |= bit;
  probe.view.frame = part;
  probe.view.targets.insert(probe.view.targets.end(), part.targets.begin(), part.targets.end());
  if (!std::all_of(probes_.begin(), probes_.end(), [](const Progress& p) { return p.complete(); })) return std::nullopt;
  std::vector<JoinedView> views;
  for (Progress& progress : probes_) {
    std::sort(progress.view.targets.begin(), progress.view.targets.end(),
              [](const auto& a, const auto& b) { return a.index < b.index; });
    views.push_back(std::move(progress.view));
  }
  probes_.clear();
  return views;
}

}  // namespace tissued::daemon
