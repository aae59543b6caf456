#include "protocol/sequence_gate.hpp"

namespace tissued::protocol {

namespace {

constexpr std::uint32_t kWindow = 64;
constexpr std::uint32_t kHalfRange = 0x80000000U;

}  // namespace

const char* to_string(SequenceVerdict verdict) {
  switch (verdict) {
    case SequenceVerdict::first:
      return "first";
    case SequenceVerdict::next:
      return "next";
    case SequenceVerdict::late:
      return "late";
    case SequenceVerdict::duplicate:
      return "duplicate";
    case SequenceVerdict::too_old:
      return "too_old";
  }
  return "unknown";
}

SequenceVerdict SequenceGate::judge(const Envelope& envelope) {
  if (!started_ || envelope.session != session_) {
    *this = SequenceGate();
    started_ = true;
    session_ = envelope.session;
    newest_ = envelope.sequence;
    seen_ = 1;
    return SequenceVerdict::first;
  }
  const std::uint32_t ahead = envelope.sequence - newest_;
  if (ahead != 0 && ahead < kHalfRange) {
    seen_ = ahead < kWindow ? (seen_ << ahead) | 1U : 1U;
    newest_ = envelope.sequence;
    since_first_ += ahead;
    lost_ += ahead - 1;
    return SequenceVerdict::next;
  }
  const std::uint32_t back = 0U - ahead;
  if (back >= kWindow) return SequenceVerdict::too_old;
  const std::uint64_t bit = std::uint64_t{1} << back;
  if ((seen_ & bit) != 0) return SequenceVerdict::duplicate;
  seen_ |= bit;
  if (back < since_first_) --lost_;  // one from before the first was never counted as lost
  return SequenceVerdict::late;
}

}  // namespace tissued::protocol
