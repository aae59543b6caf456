#include "daemon/target_answer.hpp"

#include <algorithm>

namespace tissued::daemon {

std::optional<TargetAnswer> AnswerJoiner::add(const protocol::Predictions& part, std::uint64_t receive_ns) {
  const bool same_frame = parts_seen_ != 0 && part.tracker_frame == answer_.frame.tracker_frame &&
                          part.receive_ns == answer_.frame.receive_ns && part.part_count == answer_.frame.part_count;
  if (!same_frame) {
    answer_.targets.clear();
    answer_.pads.clear();
    parts_seen_ = 0;
  }
  const std::uint64_t bit = std::uint64_t{1} << (part.part % 64);
  if ((parts_seen_ & bit) != 0) return std::nullopt;
  parts_seen_ |= bit;
  answer_.frame = part;
  answer_.receive_ns = receive_ns;
  answer_.targets.insert(answer_.targets.end(), part.targets.begin(), part.targets.end());
  answer_.pads.insert(answer_.pads.end(), part.pads.begin(), part.pads.end());
  const std::uint64_t all = part.part_count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << part.part_count) - 1;
  if ((parts_seen_ & all) != all) return std::nullopt;
  parts_seen_ = 0;
  const auto by_index = [](const auto& a, const auto& b) { return a.index < b.index; };
  std::sort(answer_.targets.begin(), answer_.targets.end(), by_index);
  std::sort(answer_.pads.begin(), answer_.pads.end(), by_index);
  return answer_;
}

}  // namespace tissued::daemon
